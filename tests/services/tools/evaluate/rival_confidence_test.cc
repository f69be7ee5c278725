#include "services/tools/evaluate/rivals/rival_confidence.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "services/tools/evaluate/methods.h"
#include "tests/services/tools/evaluate/small_scene.h"

namespace sprout::evaluate {
namespace {

constexpr float kNoDisparity = std::numeric_limits<float>::quiet_NaN();

TEST(Mirrored, SwapsTheImagesAndKeepsWhatIsSeen) {
  Frame frame;
  frame.left = (cv::Mat1b(1, 4) << 1, 2, 3, 4);
  frame.right = (cv::Mat1b(1, 4) << 5, 6, 7, 8);
  frame.rig = Rig{};
  frame.rig->pair = {.width = 4,
                     .height = 1,
                     .focal_px = 10,
                     .cx = 1.5,
                     .cy = 0,
                     .cx_right = 1,
                     .baseline_m = 0.1};
  frame.seeds = SeedSet{.seeds = {{.u = 3, .v = 0, .u_right = 1}}, .raw = 1};
  const Frame mirrored = Mirrored(frame);
  EXPECT_EQ(cv::countNonZero(cv::Mat1b(mirrored.left) != (cv::Mat1b(1, 4) << 8, 7, 6, 5)), 0);
  EXPECT_EQ(cv::countNonZero(cv::Mat1b(mirrored.right) != (cv::Mat1b(1, 4) << 4, 3, 2, 1)), 0);
  const Seed& seed = mirrored.seeds->seeds[0];
  EXPECT_EQ(seed.u, 2);  // where its point stands in the mirrored right image
  EXPECT_EQ(seed.u_right, 0);
  // The depth of a disparity is the same.
  EXPECT_EQ(mirrored.rig->pair.DepthFromDisparity(2), frame.rig->pair.DepthFromDisparity(2));
  EXPECT_EQ(mirrored.rig->pair.cx, 2);
}

// Right pixels 3, 2, 1, 0 are the mirrored ones 0 to 3.
TEST(LeftRightConfidence, FallsWithTheDifference) {
  const cv::Mat1f map = (cv::Mat1f(1, 4) << 0, 1, 1, kNoDisparity);
  const cv::Mat1f mirrored = (cv::Mat1f(1, 4) << 0, 0, 2, 1);
  const cv::Mat1b confidence = LeftRightConfidence(map, mirrored);
  EXPECT_EQ(confidence(0, 0), 128);  // right pixel 0 has 1: 255 / 2
  EXPECT_EQ(confidence(0, 1), 255);  // right pixel 0 has 1
  EXPECT_EQ(confidence(0, 2), 128);  // right pixel 1 has 2
  EXPECT_EQ(confidence(0, 3), 0) << "no disparity";
  const cv::Mat1f beyond = (cv::Mat1f(1, 4) << 2, kNoDisparity, kNoDisparity, 3);
  EXPECT_EQ(LeftRightConfidence(beyond, mirrored)(0, 0), 0) << "outside the right image";
}

TEST(WlsConfidence, IsThatOfOpenCvsFilter) {
  const cv::Size size(64, 48);
  const cv::Mat1b left(size, uint8_t{100});
  cv::Mat1f map(size, 4.F);
  cv::Mat1f mirrored(size, 4.F);
  map.rowRange(30, 48) = 8.F;  // disagrees with the right map by 4 px
  map(5, 40) = kNoDisparity;
  const cv::Mat1b confidence = WlsConfidence(left, map, mirrored);
  EXPECT_EQ(confidence(15, 40), 255);
  EXPECT_EQ(confidence(42, 40), 0);
  EXPECT_EQ(confidence(5, 40), 0) << "no disparity";
}

TEST(RivalConfidences, RankTheMapOfSprout) {
  const Scene scene = SmallScene();
  const ChainSettings settings{.config = LoadConfig({"default"}), .noise = {}};
  const cv::Mat1f expected = SelectMethods({"sprout"}).front().run(scene, settings).map_px;
  for (const char* name : {"sprout-lr", "sprout-wls"}) {
    const MethodOutput output = SelectMethods({name}).front().run(scene, settings);
    EXPECT_EQ(cv::countNonZero(output.map_px == expected), cv::countNonZero(expected == expected));
    EXPECT_EQ(output.confidence.size(), scene.size());
    EXPECT_TRUE(output.sigma.empty());
    // Both agree on most of the scene.
    EXPECT_GT(cv::countNonZero(output.confidence >= 128), scene.size().area() / 2) << name;
    EXPECT_LT(cv::countNonZero(output.confidence), scene.size().area()) << name;
  }
}

}  // namespace
}  // namespace sprout::evaluate
