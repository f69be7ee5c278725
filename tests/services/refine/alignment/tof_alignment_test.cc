#include "services/refine/alignment/tof_alignment.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "common/core/image.h"
#include "common/core/quantile.h"
#include "common/scenes/dataset.h"
#include "services/refine/refiner.h"
#include "tests/common/core/centred.h"
#include "tests/services/refine/refine_scene.h"

namespace sprout::refine {
namespace {

// A frame as TofAligner looks at it.
struct AlignScene {
  explicit AlignScene(scenes::Dataset& source, int64_t index = 0) : projector(source.rig()) {
    const scenes::DatasetFrame frame = source.Get(index);
    left = ToGrey(frame.left);
    right = ToGrey(frame.right);
    tof = frame.tof;
    int behind = 0;
    points = projector.Project(tof, behind);
  }

  TofOffset Estimate(TofAligner aligner = {}) const {
    return aligner.Estimate(left, right, points, tof, projector);
  }

  cv::Mat1b left, right;
  TofImage tof;
  TofProjector projector;
  std::vector<ProjectedPoint> points;
};

// The simulated room, whose ToF camera is turned by so much.
std::unique_ptr<scenes::Dataset> Room(double calibration_error_px) {
  CaptureConfig config;
  config.set_source("synthetic:640x480");
  config.set_tof("sr4000");
  config.mutable_sr4000()->set_calibration_error_px(calibration_error_px);
  return scenes::OpenDataset(config);
}

TEST(TofAligner, FindsHowFarTheCalibrationIsOff) {
  for (const double error_px : {1.0, 3.0, 6.0}) {
    const auto source = Room(error_px);
    std::vector<double> du_px, dv_px;
    for (int64_t frame = 0; frame < 3; ++frame) {
      const TofOffset offset = AlignScene(*source, 60 * frame).Estimate();
      EXPECT_TRUE(offset.sure) << error_px << " px, frame " << frame;
      du_px.push_back(offset.du_px);
      dv_px.push_back(offset.dv_px);
    }
    EXPECT_NEAR(Median(du_px), error_px / std::sqrt(2), 0.3);
    EXPECT_NEAR(Median(dv_px), error_px / std::sqrt(2), 0.3);
  }
}

TEST(TofAligner, TellsARightCalibrationFromAWrongOne) {
  const auto right = Room(0);
  const auto wrong = Room(3);
  for (int64_t frame = 0; frame < 150; frame += 50) {
    const TofOffset none = AlignScene(*right, frame).Estimate();
    EXPECT_TRUE(none.sure);
    EXPECT_FALSE(none.IsOff()) << none.du_px << ", " << none.dv_px;
    EXPECT_TRUE(AlignScene(*wrong, frame).Estimate().IsOff());
  }
}

TEST(TofAligner, StandardDeviationsAreOfTheSizeOfTheErrors) {
  const auto source = Room(0);
  for (int64_t frame = 0; frame < 150; frame += 50) {
    const TofOffset offset = AlignScene(*source, frame).Estimate();
    EXPECT_LT(std::abs(offset.du_px), 3 * offset.sigma_u_px);
    EXPECT_LT(std::abs(offset.dv_px), 3 * offset.sigma_v_px);
    EXPECT_LT(std::max(offset.sigma_u_px, offset.sigma_v_px), 1);
  }
}

TEST(TofAligner, IsUnsureInFrontOfAWall) {
  AlignScene scene(*Room(3));
  scene.tof.depth_m.setTo(2, scene.tof.depth_m == scene.tof.depth_m);
  int behind = 0;
  scene.points = scene.projector.Project(scene.tof, behind);
  const TofOffset offset = scene.Estimate();
  EXPECT_FALSE(offset.sure);
  EXPECT_FALSE(offset.IsOff());
  EXPECT_EQ(offset.sigma_u_px, std::numeric_limits<double>::infinity());
}

TEST(TofAligner, IsUnsureWithoutPointsAndWithoutPictures) {
  AlignScene scene(*Room(3));
  AlignScene no_points = scene;
  no_points.points.clear();
  EXPECT_FALSE(no_points.Estimate().sure);
  AlignScene blank = scene;
  blank.left = cv::Mat1b(scene.left.size(), uint8_t{100});
  blank.right = blank.left;
  EXPECT_FALSE(blank.Estimate().sure);
  AlignScene noise = scene;
  cv::RNG random(1);
  random.fill(noise.left, cv::RNG::UNIFORM, 0, 255);
  random.fill(noise.right, cv::RNG::UNIFORM, 0, 255);
  EXPECT_FALSE(noise.Estimate().sure);
}

TEST(TofAligner, GivesTheSameWithAnyNumberOfThreadsAndAnyHistory) {
  const auto source = Room(3);
  const AlignScene scene(*source, 10);
  const AlignScene other(*source, 90);
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1);
  const TofOffset one = scene.Estimate();
  cv::setNumThreads(3);
  TofAligner aligner;
  other.Estimate(aligner);
  EXPECT_EQ(aligner.Estimate(scene.left, scene.right, scene.points, scene.tof, scene.projector),
            one);
  cv::setNumThreads(threads);
}

TEST(TofAligner, BearsACalibrationThatIsNone) {
  AlignScene scene(*Room(0));
  Rig rig = scene.projector.rig();
  for (const double focal_px : {1e-6, 1e9}) {
    rig.tof.fx = rig.tof.fy = focal_px;
    const TofProjector projector(rig);
    TofAligner aligner;
    EXPECT_FALSE(
        aligner.Estimate(scene.left, scene.right, scene.points, scene.tof, projector).sure);
  }
}

TEST(ApplyOffset, MovesPointsByTheOffsetWhateverTheirDepth) {
  RectifiedPair pair = CentredPair(1000, 800, 2000);
  Rig rig{.pair = pair, .tof = {}};
  rig.tof.left_from_tof_translation_m = {0.05, -0.02, 0};
  std::vector<ProjectedPoint> points;
  for (const double z : {0.5, 1.0, 4.0}) {
    points.push_back({0, 0, ProjectToPair(pair, Eigen::Vector3d(0.01, 0.02, z))});
  }
  const std::vector<ProjectedPoint> before = points;
  const TofOffset offset{.du_px = 3, .dv_px = -2};
  ApplyOffset(offset, rig, points);
  for (size_t i = 0; i < points.size(); ++i) {
    EXPECT_NEAR(points[i].seed.u - before[i].seed.u, 3, 0.05);
    EXPECT_NEAR(points[i].seed.v - before[i].seed.v, -2, 0.05);
    EXPECT_NEAR(points[i].seed.disparity(), before[i].seed.disparity(), 0.1);
  }
  ApplyOffset({.du_px = -3, .dv_px = 2}, rig, points);
  for (size_t i = 0; i < points.size(); ++i) {
    EXPECT_NEAR(points[i].seed.u, before[i].seed.u, 1e-3);
    EXPECT_NEAR(points[i].seed.v, before[i].seed.v, 1e-3);
  }
}

// Sum of the distances between the seeds of one ToF pixel in both sets, and how many there are.
double MeanDistance(const SeedSet& a, const SeedSet& b) {
  double sum = 0;
  int count = 0;
  for (const Seed& seed : a.seeds) {
    const auto same = std::ranges::find_if(b.seeds, [&](const Seed& other) {
      return other.tof_u == seed.tof_u && other.tof_v == seed.tof_v;
    });
    if (seed.origin != SeedOrigin::kTof || same == b.seeds.end()) continue;
    sum += std::hypot(seed.u - same->u, seed.v - same->v);
    ++count;
  }
  return sum / count;
}

TEST(Refiner, MovesThePointsOfATofCameraThatIsOff) {
  RefineConfig config;
  config.set_stereo_seeds(false);
  config.set_align_tof(false);
  RefineConfig aligning = config;
  aligning.set_align_tof(true);
  Refiner plain(config);
  Refiner refiner(aligning);
  for (const double error_px : {0.0, 6.0}) {
    const AlignScene scene(*Room(error_px));
    const auto compute = [&](Refiner& with) {
      return with.Compute(scene.left, scene.right, scene.tof, scene.projector).value();
    };
    const SeedSet without = compute(plain);
    const SeedSet seeds = compute(refiner);
    EXPECT_EQ(plain.found().tof_offset, TofOffset());
    EXPECT_TRUE(refiner.found().tof_offset.sure);
    if (error_px == 0) {
      EXPECT_FALSE(refiner.found().tof_offset.IsOff());
      EXPECT_EQ(seeds, without);
    } else {
      EXPECT_NEAR(MeanDistance(without, seeds), error_px, 0.5);
    }
  }
}

// Edges lie where there are none.
TEST(Refiner, MovesNoPointsByImagesThatDoNotFitEachOther) {
  AlignScene scene(*Room(3));
  cv::flip(scene.right, scene.right, 0);
  ASSERT_TRUE(scene.Estimate().IsOff());
  Refiner refiner{RefineConfig()};
  const SeedSet seeds =
      refiner.Compute(scene.left, scene.right, scene.tof, scene.projector).value();
  EXPECT_TRUE(refiner.found().range_error.pair_unfit);
  EXPECT_FALSE(refiner.found().tof_offset.IsOff());
  EXPECT_EQ(std::ranges::count(seeds.seeds, SeedOrigin::kStereo, &Seed::origin), 0);
  RefineConfig config;
  config.set_align_tof(false);
  const SeedSet unaligned =
      Refiner(config).Compute(scene.left, scene.right, scene.tof, scene.projector).value();
  EXPECT_LT(MeanDistance(unaligned, seeds), 0.01);
}

// A slanted wall behind a box of hardly any texture. What is bright ends 6 px right of the box.
struct ShadowScene : BoxScene {
  static constexpr double kWallPx = 5, kSlope = 0.1, kBoxPx = 45;
  static inline const cv::Rect kBox{150, 80, 120, 140};

  static double DisparityAt(const cv::Point2f& at) {
    return kBox.contains(cv::Point(at)) ? kBoxPx : kWallPx + kSlope * double{at.x};
  }

  ShadowScene() {
    cv::RNG(5).fill(left, cv::RNG::UNIFORM, 80, 120);
    cv::GaussianBlur(left, left, {}, 1);
    left(kBox + cv::Point(6, 0)) += 60;
    cv::Mat1f columns(left.size()), rows(left.size());
    for (int v = 0; v < left.rows; ++v) {
      for (int u = 0; u < left.cols; ++u) {
        const bool is_box = kBox.contains(cv::Point(u + static_cast<int>(kBoxPx), v));
        columns(v, u) = static_cast<float>(is_box ? u + kBoxPx : (u + kWallPx) / (1 - kSlope));
        rows(v, u) = static_cast<float>(v);
      }
    }
    cv::remap(left, right, columns, rows, cv::INTER_LINEAR, cv::BORDER_REFLECT);
    for (int j = 0; j < rig.tof.height; ++j) {
      for (int i = 0; i < rig.tof.width; ++i)
        SetDisparity(i, j, DisparityAt(cv::Point(5 * i, 5 * j)));
    }
  }
};

TEST(Refiner, MovesNoPointsToWhereTheImagesFitThemLess) {
  const ShadowScene scene;
  const TofProjector projector(scene.rig);
  int behind = 0;
  const std::vector<ProjectedPoint> points = projector.Project(scene.tof, behind);
  const TofOffset offset =
      TofAligner().Estimate(scene.left, scene.right, points, scene.tof, projector);
  ASSERT_TRUE(offset.IsOff());
  EXPECT_NEAR(offset.du_px, 6, 1);
  Refiner refiner{RefineConfig()};
  const SeedSet set = refiner.Compute(scene.left, scene.right, scene.tof, projector).value();
  EXPECT_FALSE(refiner.found().tof_offset.IsOff());
  const auto is_wrong = [](const Seed& seed) {
    return std::abs(double{seed.disparity()} - ShadowScene::DisparityAt({seed.u, seed.v})) > 0.3;
  };
  EXPECT_GT(set.seeds.size(), 2000U);
  EXPECT_LT(std::ranges::count_if(set.seeds, is_wrong), std::ssize(set.seeds) / 50);
}

}  // namespace
}  // namespace sprout::refine
