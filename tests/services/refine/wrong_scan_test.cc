#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <opencv2/imgproc.hpp>

#include "services/refine/refine_adapter.h"
#include "services/refine/refiner.h"
#include "tests/services/refine/refine_scene.h"

namespace sprout::refine {
namespace {

using testing::HasSubstr;

// A scan of scattered points. @param move_px  how far right of where they belong they lie.
BoxScene ScatteredScene(int move_px) {
  BoxScene scene(move_px);
  cv::Mat1f kept(scene.tof.depth_m.size());
  cv::RNG(7).fill(kept, cv::RNG::UNIFORM, 0, 1);
  scene.tof.depth_m.setTo(kNoReturn, kept > 0.15);
  return scene;
}

// The same where every fifth return is of another depth.
BoxScene MixedScene() {
  BoxScene scene = ScatteredScene(0);
  int returns = 0;
  for (float& depth_m : scene.tof.depth_m) {
    if (depth_m > 0 && ++returns % 5 == 0) depth_m *= 1.3F;
  }
  return scene;
}

void ExpectNoneIsBelieved(BoxScene wrong, Refiner& refiner) {
  const auto seeds = refiner.Compute(wrong.left, wrong.right, wrong.tof, TofProjector(wrong.rig));
  EXPECT_TRUE(refiner.found().range_error.rejected);
  EXPECT_EQ(seeds->contradicted, seeds->raw - seeds->outside);
  EXPECT_TRUE(refiner.left_seeds().seeds.empty());
  wrong.tof = {};
  wrong.rig.tof = {};
  EXPECT_EQ(seeds->seeds, wrong.Refine(RefineConfig())->seeds);
}

TEST(WrongScan, IsNotBelieved) {
  Refiner refiner{RefineConfig()};
  ExpectNoneIsBelieved(MixedScene(), refiner);
  EXPECT_NEAR(refiner.found().contradiction.share, 0.17, 0.05);
}

// Too far to be put right: that takes edges of more than these boxes.
TEST(WrongScan, IsNotBelievedElsewhere) {
  Refiner refiner{RefineConfig()};
  ExpectNoneIsBelieved(ScatteredScene(60), refiner);
  EXPECT_NEAR(refiner.found().sensor_place.move_px.x, -60, 2);
}

TEST(WrongScan, IsNoRightOne) {
  const BoxScene right = ScatteredScene(0);
  Refiner refiner{RefineConfig()};
  const auto seeds = refiner.Compute(right.left, right.right, right.tof, TofProjector(right.rig));
  EXPECT_FALSE(refiner.found().range_error.rejected);
  EXPECT_GT(CountTofSeeds(seeds->seeds), 500);
}

// The error beside a right scan if the right image has been taken from other places.
RangeError ErrorBesideRight(const std::function<cv::Point(const cv::Point&)>& from) {
  BoxScene scene = ScatteredScene(0);
  for (cv::Mat1b* image : {&scene.left, &scene.right}) cv::GaussianBlur(*image, *image, {}, 1);
  const cv::Mat1b right = scene.right.clone();
  for (int v = 0; v < right.rows; ++v) {
    for (int u = 0; u < right.cols; ++u) {
      const cv::Point at = from({u, v});
      scene.right(v, u) = right(std::clamp(at.y, 0, right.rows - 1), std::max(0, at.x));
    }
  }
  Refiner refiner{RefineConfig()};
  const auto seeds =
      refiner.Compute(scene.left, scene.right, scene.tof, TofProjector(scene.rig)).value();
  EXPECT_GT(CountTofSeeds(seeds.seeds), 400);
  EXPECT_FALSE(refiner.found().range_error.rejected);
  return refiner.found().range_error;
}

TEST(WrongScan, IsNoRightOneBesideAPairThatIsTurned) {
  const auto turned = [](const cv::Point& at) {
    return cv::Point(at.x, at.y - static_cast<int>(std::lround(0.01 * (at.x - 200))));
  };
  const RangeError error = ErrorBesideRight(turned);
  EXPECT_TRUE(error.IsUnknown());
  EXPECT_GE(error.columns_px, 1);
}

TEST(WrongScan, IsNoRightOneBesideAHalfThatHangs) {
  const auto half = [](const cv::Point& at) { return at.y < 150 ? at : cv::Point(at.x - 6, at.y); };
  EXPECT_TRUE(ErrorBesideRight(half).rows_shifted);
}

// One range, as of a distance sensor, nearer than all that the images show.
TEST(WrongRange, IsRefusedWhereItIsTheOnlyOne) {
  BoxScene scene;
  scene.rig.tof.width = scene.rig.tof.height = 1;
  scene.rig.tof.cx = scene.rig.tof.cy = 0;
  scene.tof.depth_m = cv::Mat1f(1, 1, static_cast<float>(scene.rig.pair.DepthFromDisparity(90)));
  const StageResult result = RefineAdapter(RefineConfig()).Process(FrameOf(scene));
  EXPECT_TRUE(result.ranges_refused);
  EXPECT_THAT(result.degenerate, HasSubstr("100 % of the points are not believed"));
}

TEST(WrongScan, IsSaid) {
  const StageResult result = RefineAdapter(RefineConfig()).Process(FrameOf(MixedScene()));
  EXPECT_TRUE(result.ranges_refused);
  EXPECT_THAT(result.degenerate, HasSubstr("stereo contradicts the range points at"));
  EXPECT_EQ(result.finding.value_or(""), "");
  RefineFindings found;
  found.sensor_place = {.is_displaced = true, .move_px = {}, .shear = -0.15};
  EXPECT_THAT(DegenerateText(found, {}, true),
              HasSubstr("belong 0.15 px further left for each px further down"));
  found.sensor_place = {.is_displaced = true, .move_px = {}, .in_right_image = true};
  EXPECT_THAT(DegenerateText(found, {}, true), HasSubstr("lie where the right one does"));
}

}  // namespace
}  // namespace sprout::refine
