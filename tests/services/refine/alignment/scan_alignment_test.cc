#include "services/refine/alignment/scan_alignment.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "common/core/image.h"
#include "common/scenes/dataset.h"
#include "tests/services/refine/refine_scene.h"

namespace sprout::refine {
namespace {

using ::testing::HasSubstr;

// What is wrong with a scan.
struct ScanError {
  double right_px = 0, down_px = 0;  // its points are projected so far beside their places
  double roll_rad = 0;               // and turned about the optical axis, clockwise > 0
  double farther_m = 0;              // the rig has moved forward since; less than 0: is yet to
  double longer_m = 0;               // its ranges are too long
  bool in_right_image = false;       // its points are projected for the right camera
};

// A frame of the simulated room, as a lidar sees it from the left camera's place: a return every 4
// px along beams that are 10 px apart.
struct ScanScene : Scene {
  explicit ScanScene(const ScanError& error = {}, int64_t index = 0) {
    CaptureConfig config;
    config.set_source("synthetic:640x480");
    config.set_tof("none");
    const std::unique_ptr<scenes::Dataset> source = scenes::OpenDataset(config);
    const scenes::DatasetFrame frame = source->Get(index);
    left = ToGrey(frame.left);
    right = ToGrey(frame.right);
    rig.pair = source->rig().pair;
    truth = frame.truth.left;
    rig.tof = TofOverLeft(rig.pair, left.size());
    tof.depth_m = cv::Mat1f(left.size(), std::numeric_limits<float>::quiet_NaN());
    for (int v = 3; v < left.rows; v += 10) {
      for (int u = 1; u < left.cols; u += 4) {
        const double disparity = double{frame.truth.left(v, u)};
        if (!(disparity > 0)) continue;
        const double across = u - rig.pair.cx;
        const double down = v - rig.pair.cy;
        const double beside_px = error.right_px - (error.in_right_image ? disparity : 0);
        Add({u + beside_px - error.roll_rad * down, v + error.down_px + error.roll_rad * across},
            rig.pair.DepthFromDisparity(disparity), error);
      }
    }
    int behind = 0;
    points = TofProjector(rig).Project(tof, behind);
  }

  ScanMove Estimate(ScanAligner aligner = {}) const {
    TofSurface surface(rig, points);
    const double noise_px = surface.Noise(points).middle_px;
    return aligner.Estimate({left, right, rig, surface, noise_px, false}, points);
  }

  std::vector<ProjectedPoint> points;
  cv::Mat1f truth;  // disparities of the left image

 private:
  void Add(const cv::Point2d& at, double z, const ScanError& error) {
    Eigen::Vector3d point((at.x - rig.pair.cx) / rig.pair.focal_px * z,
                          (at.y - rig.pair.cy) / rig.pair.focal_px * z, z);
    point *= 1 + error.longer_m / point.norm();
    point.z() += error.farther_m;
    const Seed seed = ProjectToPair(rig.pair, point);
    const cv::Point pixel(static_cast<int>(std::lround(seed.u)),
                          static_cast<int>(std::lround(seed.v)));
    if (!cv::Rect({}, tof.depth_m.size()).contains(pixel)) return;
    tof.depth_m(pixel) = static_cast<float>(point.z());
  }
};

TEST(ScanAligner, FindsHowFarAScanIsTurned) {
  for (const ScanError& error : {ScanError{.right_px = 5}, ScanError{.right_px = -4, .down_px = 3},
                                 ScanError{.down_px = -4}}) {
    const ScanMove move = ScanScene(error).Estimate();
    EXPECT_TRUE(move.is_off) << error.right_px << ", " << error.down_px;
    EXPECT_NEAR(move.du_px, -error.right_px, 1);
    EXPECT_NEAR(move.dv_px, -error.down_px, 1);
    EXPECT_EQ(move.nearer_m, 0);
    EXPECT_EQ(move.roll_rad, 0);
  }
}

TEST(ScanAligner, FindsHowFarAScanIsRolled) {
  for (const double roll_rad : {0.02, -0.02, 0.03, -0.03}) {
    const ScanMove move = ScanScene({.roll_rad = roll_rad}).Estimate();
    EXPECT_TRUE(move.is_off) << roll_rad;
    EXPECT_NEAR(move.roll_rad, -roll_rad, 0.006);  // 2 px at half the width
    EXPECT_NEAR(move.du_px, 0, 1);
    EXPECT_NEAR(move.dv_px, 0, 1);
    EXPECT_EQ(move.nearer_m, 0);
  }
}

TEST(ScanAligner, LeavesARightScanAlone) {
  for (int64_t frame = 0; frame < 150; frame += 50) {
    const ScanMove move = ScanScene({}, frame).Estimate();
    EXPECT_FALSE(move.is_off) << move.du_px << ", " << move.dv_px << ", " << move.nearer_m;
  }
}

TEST(ScanAligner, FindsHowFarTheRigMovesBetweenScanAndPair) {
  for (const double farther_m : {0.1, 0.3, -0.3}) {
    const ScanMove move = ScanScene({.farther_m = farther_m}).Estimate();
    EXPECT_TRUE(move.is_off) << farther_m;
    EXPECT_NEAR(move.nearer_m, farther_m, 0.03);
    EXPECT_NEAR(move.du_px, 0, 1);
    EXPECT_NEAR(move.dv_px, 0, 1);
  }
}

TEST(ScanAligner, LeavesRangesThatAreOffToTheirOwnEstimate) {
  const ScanMove move = ScanScene({.longer_m = 0.05}).Estimate();
  EXPECT_FALSE(move.is_off) << move.du_px << ", " << move.dv_px << ", " << move.nearer_m;
}

TEST(ScanAligner, MovesNothingThatTheImagesDoNotShow) {
  const ScanScene scene({.right_px = 5});
  ScanScene few = scene;
  few.points.resize(90);
  EXPECT_EQ(few.Estimate(), ScanMove());
  ScanScene blank = scene;
  blank.left = cv::Mat1b(scene.left.size(), uint8_t{100});
  blank.right = blank.left;
  EXPECT_FALSE(blank.Estimate().is_off);
  ScanScene noise = scene;
  cv::RNG random(1);
  random.fill(noise.left, cv::RNG::UNIFORM, 0, 255);
  random.fill(noise.right, cv::RNG::UNIFORM, 0, 255);
  EXPECT_FALSE(noise.Estimate().is_off);
  ScanScene far = scene;
  for (ProjectedPoint& point : far.points) point.seed.u_right = point.seed.u;
  EXPECT_FALSE(far.Estimate().is_off);
}

TEST(ScanAligner, GivesTheSameWithAnyNumberOfThreadsAndAnyHistory) {
  const ScanScene scene({.right_px = 3, .down_px = 2}, 10);
  const ScanScene other({.farther_m = 0.2}, 90);
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1);
  const ScanMove one = scene.Estimate();
  cv::setNumThreads(3);
  ScanAligner aligner;
  TofSurface surface(other.rig, other.points);
  aligner.Estimate({other.left, other.right, other.rig, surface, 0, false}, other.points);
  EXPECT_EQ(scene.Estimate(aligner), one);
  cv::setNumThreads(threads);
}

TEST(ApplyMove, TakesBackWhatAScanIsOffBy) {
  const ScanScene scene;
  const Eigen::Vector3d place(0.02, -0.01, 2.4);
  const ProjectedPoint point{0, 0, ProjectToPair(scene.rig.pair, place)};
  std::vector<ProjectedPoint> points = {point};
  ApplyMove({.du_px = 2, .dv_px = -3, .nearer_m = 0.4}, scene.rig, points);
  const Seed expected = ProjectToPair(scene.rig.pair, {place.x(), place.y(), 2});
  EXPECT_NEAR(points[0].seed.u, expected.u + 2, 0.02);
  EXPECT_NEAR(points[0].seed.v, expected.v - 3, 0.02);
  EXPECT_NEAR(points[0].seed.disparity(), expected.disparity(), 0.02);
  // About the middle of the left image, clockwise.
  points = {point};
  ApplyMove({.roll_rad = 0.01}, scene.rig, points);
  EXPECT_NEAR(points[0].seed.u, point.seed.u - 0.01 * (point.seed.v - scene.rig.pair.cy), 0.01);
  EXPECT_NEAR(points[0].seed.v, point.seed.v + 0.01 * (point.seed.u - scene.rig.pair.cx), 0.01);
  EXPECT_NEAR(points[0].seed.disparity(), point.seed.disparity(), 0.01);
  // Behind the cameras nothing can be seen.
  points = {point};
  ApplyMove({.nearer_m = 3}, scene.rig, points);
  EXPECT_EQ(points[0].seed, point.seed);
}

TEST(ScanMoveText, SaysWhatWasDoneAndWhatItMeans) {
  EXPECT_EQ(
      ScanMoveText({.du_px = 2, .dv_px = -3}),
      "the lidar's points fit the pair when moved by (+2, -3) px in the left image, and were: "
      "it is turned, or it measures at another moment");
  EXPECT_THAT(ScanMoveText({.du_px = 2, .dv_px = -3, .roll_rad = 0.0175}),
              HasSubstr("(+2, -3) px in the left image and rolled by +1.00°, and were: it is"));
  EXPECT_THAT(ScanMoveText({.du_px = 0, .dv_px = 1, .nearer_m = 0.74}),
              HasSubstr("by (+0, +1) px in the left image and 0.74 m nearer, and were: it measures "
                        "at another moment"));
  EXPECT_THAT(ScanMoveText({.du_px = 0, .dv_px = 1, .nearer_m = -0.74}),
              HasSubstr("and 0.74 m farther, and"));
}

TEST(Refiner, MovesAScanThatIsOff) {
  RefineConfig config;
  config.set_stereo_seeds(false);
  config.set_range_bias(RefineConfig::OFF);
  const ScanScene scene({.right_px = 5});
  const auto seeds_of = [&](Refiner& refiner) {
    return refiner.Compute(scene.left, scene.right, scene.tof, TofProjector(scene.rig)).value();
  };
  Refiner refiner(config);
  const SeedSet moved = seeds_of(refiner);
  EXPECT_TRUE(refiner.found().scan_move.is_off);
  EXPECT_FALSE(refiner.found().tof_offset.sure);
  const double du_px = refiner.found().scan_move.du_px;
  EXPECT_NEAR(du_px, -5, 1);
  config.set_align_tof(false);
  Refiner plain(config);
  const SeedSet as_is = seeds_of(plain);
  EXPECT_FALSE(plain.found().scan_move.is_off);
  const auto at = [](const SeedSet& seeds, int u, int v) {
    for (const Seed& seed : seeds.seeds) {
      if (seed.tof_u == u && seed.tof_v == v) return double{seed.u};
    }
    return std::numeric_limits<double>::quiet_NaN();
  };
  int compared = 0;
  for (const Seed& seed : as_is.seeds) {
    const double u = at(moved, seed.tof_u, seed.tof_v);
    if (std::isnan(u) || std::abs(u - scene.rig.pair.cx) > 100) continue;
    EXPECT_NEAR(u - double{seed.u}, du_px, 0.25);
    ++compared;
  }
  EXPECT_GT(compared, 500);
}

// By the seeds that it makes of the scan: how many, and how many of them by more than 1 px off.
struct Believed {
  int seeds = 0;
  int wrong = 0;
};

Believed BelievedOf(Refiner& refiner, const ScanScene& scene) {
  const SeedSet seeds =
      refiner.Compute(scene.left, scene.right, scene.tof, TofProjector(scene.rig)).value();
  Believed believed;
  for (const Seed& seed : seeds.seeds) {
    if (seed.origin != SeedOrigin::kTof) continue;
    ++believed.seeds;
    const float there =
        scene.truth(static_cast<int>(std::lround(seed.v)), static_cast<int>(std::lround(seed.u)));
    if (!(std::abs(there - seed.disparity()) <= 1)) ++believed.wrong;
  }
  return believed;
}

// Farther than the alignment looks by itself.
TEST(Refiner, MovesAScanThatStereoShowsToBeFarOff) {
  const ScanScene scene({.right_px = 36});
  ASSERT_GT(scene.Estimate().du_px, -33);
  Refiner refiner{RefineConfig()};
  const Believed believed = BelievedOf(refiner, scene);
  EXPECT_TRUE(refiner.found().scan_move.is_off);
  EXPECT_NEAR(refiner.found().scan_move.du_px, -36, 2);
  EXPECT_NEAR(refiner.found().scan_move.dv_px, 0, 1);
  EXPECT_FALSE(refiner.found().sensor_place.is_displaced);
  EXPECT_GT(believed.seeds, 1000);
  EXPECT_LT(believed.wrong, believed.seeds / 10);
}

TEST(Refiner, BelievesNoScanOfTheRightImage) {
  Refiner refiner{RefineConfig()};
  EXPECT_EQ(BelievedOf(refiner, ScanScene({.in_right_image = true})).seeds, 0);
  EXPECT_TRUE(refiner.found().sensor_place.in_right_image);
  EXPECT_FALSE(refiner.found().scan_move.is_off);
  EXPECT_GT(BelievedOf(refiner, ScanScene()).seeds, 1000);
}

// Two fifths of the right image show something else, so it is the pair that is wrong.
TEST(Refiner, TakesAMoveBackBesideAPairThatDoesNotFit) {
  ScanScene scene({.right_px = 5});
  cv::Mat1b part = scene.right.rowRange(0, 2 * scene.right.rows / 5);
  cv::RNG(3).fill(part, cv::RNG::UNIFORM, 0, 256);
  ASSERT_TRUE(scene.Estimate().is_off);
  const auto seeds_of = [&](Refiner refiner) {
    const auto seeds =
        refiner.Compute(scene.left, scene.right, scene.tof, TofProjector(scene.rig)).value();
    EXPECT_TRUE(refiner.found().range_error.pair_unfit);
    EXPECT_FALSE(refiner.found().scan_move.is_off);
    return seeds.seeds;
  };
  RefineConfig config;
  const std::vector<Seed> taken_back = seeds_of(Refiner(config));
  config.set_align_tof(false);
  EXPECT_EQ(taken_back, seeds_of(Refiner(config)));
}

TEST(RefineAdapter, SaysThatAScanWasMoved) {
  RefineAdapter adapter{RefineConfig()};
  const auto said = [&](const ScanScene& scene) {
    return adapter.Process(FrameOf(scene)).finding.value_or("");
  };
  EXPECT_THAT(said(ScanScene({.farther_m = 0.3})), HasSubstr("measures at another moment"));
  EXPECT_EQ(said(ScanScene()), "");
}

}  // namespace
}  // namespace sprout::refine
