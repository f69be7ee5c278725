// Real images, which are not part of the project: prints the figures of
// services/tools/calibrate/NOTES.md.

#include <fmt/core.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <numbers>
#include <opencv2/imgcodecs.hpp>

#include "common/rig/rectifier.h"
#include "common/scenes/dataset.h"
#include "services/tools/calibrate/report.h"
#include "services/tools/calibrate/scene/rig_change.h"
#include "services/tools/calibrate/scene/scene_refiner.h"
#include "tests/common/rig/kitti_raw.h"

namespace sprout::calibrate {
namespace {

namespace fs = std::filesystem;

fs::path DataFolder(const char* name) {
  const char* data = std::getenv("SPROUT_DATA");
  return fs::path(data == nullptr ? "" : data) / name;
}

TEST(SceneData, PutsTheRowsOfKittiRawRight) {
  const fs::path folder = DataFolder("kitti_raw");
  if (!fs::exists(folder)) GTEST_SKIP() << "SPROUT_DATA is not set, or has no kitti_raw";
  const RawRig rig = KittiRig(ReadKittiValues(folder / "calib_cam_to_cam.txt"));
  const Rectifier rectifier(rig);
  SceneRefiner refiner(rig, RectificationOf(rig));
  for (const int number : {336, 338, 340}) {
    const std::string name = "0000000" + std::to_string(number) + "_cam";
    const auto images = RectifyImages(
        rectifier, {.left = cv::imread(folder / (name + "0.png"), cv::IMREAD_GRAYSCALE),
                    .right = cv::imread(folder / (name + "1.png"), cv::IMREAD_GRAYSCALE),
                    .tof = {}});
    ASSERT_TRUE(images) << images.error().text;
    ASSERT_TRUE(refiner.Add(images->left, images->right, images->tof));
  }

  const auto refined = refiner.Refine({});

  ASSERT_TRUE(refined) << refined.error().text;
  std::cout << SceneSummaryText(*refined);
  EXPECT_GT(std::abs(refined->before.rows_median_px), 0.3);
  EXPECT_LT(std::abs(refined->after.rows_median_px), 0.3);
  EXPECT_LT(refined->after.rows_abs_median_px, refined->before.rows_abs_median_px);
}

TEST(SceneData, TellsTheYawAgainstTheLidarOfKittiVideo) {
  for (const char* drive : {"00", "03"}) {  // drive 07 hardly has points on planes
    const fs::path folder = DataFolder("kitti_video") / drive;
    if (!fs::exists(folder)) GTEST_SKIP() << "SPROUT_DATA is not set, or has no kitti_video";
    CaptureConfig config;
    config.set_source("kitti:" + folder.string());
    const std::unique_ptr<scenes::Dataset> dataset = scenes::OpenDataset(config);
    const Rectification as_it_is{.left_turn = cv::Matx33d::eye(),
                                 .right_turn = cv::Matx33d::eye(),
                                 .pair = dataset->rig().pair};
    SceneRefiner refiner(RawRigOf(dataset->rig()), as_it_is);
    for (const int64_t frame : {0, 2, 4, 6, 8}) {
      const scenes::DatasetFrame images = dataset->Get(frame);
      ASSERT_TRUE(refiner.Add(images.left, images.right, images.tof));
    }

    const auto refined = refiner.Refine({});

    ASSERT_TRUE(refined) << refined.error().text;
    std::cout << drive << "\n" << SceneSummaryText(*refined);
    EXPECT_TRUE(refined->adjusted.seen[kYaw]);
    EXPECT_LT(refined->adjusted.sigma[kYaw] * dataset->rig().pair.focal_px, 0.2);  // px
    EXPECT_LT(std::abs(refined->adjusted.change[kYaw]), 0.1 * std::numbers::pi / 180);
  }
}

// A ToF camera as it should be, turned, moved aside and with ranges that wiggle; a right camera
// that is turned. Prints each error and its standard deviation.
TEST(SceneData, ClaimsNoMoreThanTheFramesTell) {
  constexpr double kDegree = std::numbers::pi / 180;
  struct Knock {
    const char* options;
    RigNumber number;
    double by;
    double aside_m;
    double wiggle_m = 0;
  };
  const Knock knocks[] = {{"", kTofYaw, 0, 0},
                          {"&wiggle=10", kTofYaw, 0, 0, 0.01},
                          {"", kTofYaw, 0.3 * kDegree, 0},
                          {"", kTofYaw, 0, 0.005},
                          {"", kYaw, 0.1 * kDegree, 0}};
  for (const char* scene : {"Books", "Dolls", "Cloth3"}) {
    const fs::path folder = DataFolder("middlebury") / "half" / scene;
    if (!fs::exists(folder)) GTEST_SKIP() << "SPROUT_DATA is not set, or has no middlebury";
    for (const Knock& knock : knocks) {
      CaptureConfig config;
      config.set_source("middlebury:" + folder.string() + "?tof=sr4000" + knock.options);
      const std::unique_ptr<scenes::Dataset> dataset = scenes::OpenDataset(config);
      const RectifiedPair& pair = dataset->rig().pair;
      RigNumbers error{};
      error[knock.number] = -knock.by;
      RawRig rig = Changed(RawRigOf(dataset->rig()), error);
      rig.left_from_tof.translation_m.x() += knock.aside_m;
      SceneRefiner refiner(
          rig, {.left_turn = cv::Matx33d::eye(), .right_turn = cv::Matx33d::eye(), .pair = pair},
          QuickEffort(pair));
      const scenes::DatasetFrame images = dataset->Get(0);
      ASSERT_TRUE(refiner.Add(images.left, images.right, images.tof));
      const auto refined = refiner.Refine({});
      ASSERT_TRUE(refined) << refined.error().text;
      const AdjustedScene& adjusted = refined->adjusted;
      for (const RigNumber number : {kYaw, kTofPitch, kTofYaw}) {
        const RigNumberRow& row = RowOf(number);
        const double off = adjusted.change[number] + error[number];
        std::cout << fmt::format("{} {}: {} is off by {:.3f} ± {:.3f} {}\n", scene, &knock - knocks,
                                 row.name, row.per_unit * off,
                                 row.per_unit * adjusted.sigma[number], row.unit);
        EXPECT_LT(std::abs(off), 3 * adjusted.sigma[number]);
        const bool is_wrong = number == knock.number && knock.by != 0;
        const bool is_aside = number == kTofYaw && knock.aside_m != 0;
        EXPECT_EQ(adjusted.change[number] != 0, is_wrong || is_aside);
      }
      EXPECT_TRUE(refined->curve.empty() || knock.wiggle_m != 0) << scene;
      for (const CorrectionKnot& knot : refined->curve) {
        const double offset_m = adjusted.change[kRangeOffset];
        const double phase = 2 * std::numbers::pi * (knot.range_m - offset_m) / 1.25;
        const double left_m = knot.offset_m + offset_m + knock.wiggle_m * std::sin(phase);
        std::cout << fmt::format("{} {}: ranges at {:.2f} m are off by {:.1f} ± {:.1f} mm\n", scene,
                                 &knock - knocks, knot.range_m, 1000 * left_m, 1000 * knot.sigma_m);
        EXPECT_LT(std::abs(left_m), 3 * knot.sigma_m);
      }
    }
  }
}

}  // namespace
}  // namespace sprout::calibrate
