// Real images, which are not part of the project: prints the figures of
// services/tools/calibrate/NOTES.md.

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

}  // namespace
}  // namespace sprout::calibrate
