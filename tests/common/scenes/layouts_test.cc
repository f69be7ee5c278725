// Layouts of data sets as they are published, beside those of the other tests.

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "common/scenes/middlebury_calibration.h"
#include "tests/common/scenes/scene_folder.h"

namespace sprout::scenes {
namespace {

using testing::HasSubstr;

const cv::Size kSize{40, 30};

TEST(Layouts, MiddleburyOf2003HasFourCodesAPixelInItsSmallestSizeAndOf2001Eight) {
  for (const auto& [rows, codes] : {std::pair{72, 4}, {375, 4}, {750, 2}, {1500, 1}, {383, 8}}) {
    const SceneFolder folder;
    const cv::Size size(20, rows);
    folder.WriteImage("im2.png", SomePicture(size));
    folder.WriteImage("im6.png", SomePicture(size));
    folder.WriteImage("disp2.png", cv::Mat1b(size, uint8_t{40}));
    folder.WriteImage("disp6.png", cv::Mat1b(size, uint8_t{20}));
    const DatasetFrame frame = folder.Open()->Get(0);
    EXPECT_EQ(frame.truth.left(5, 5), 40.0F / static_cast<float>(codes));
    EXPECT_EQ(frame.truth.right(5, 5), 20.0F / static_cast<float>(codes));
  }
}

TEST(Layouts, MiddleburysEvaluationAndEth3dHaveDisp0GtAndAMask) {
  const SceneFolder folder(SceneFolder::k2014);
  folder.Remove("disp0.pfm");
  EXPECT_THAT(OpenError(folder.Config()), HasSubstr("allowed: disp0.pfm, disp0GT.pfm"));
  cv::Mat1f truth(20, 30, 5.5F);
  truth(0, 0) = std::numeric_limits<float>::infinity();
  folder.WritePfm("disp0GT.pfm", truth, "-1");
  EXPECT_TRUE(folder.Open()->Get(0).truth.nonoccluded.empty());
  cv::Mat1b mask(20, 30, uint8_t{255});
  mask(3, 4) = 128;
  folder.WriteImage("mask0nocc.png", mask);
  const DatasetFrame frame = folder.Open()->Get(0);
  EXPECT_EQ(frame.truth.left(3, 4), 5.5F);
  EXPECT_TRUE(std::isnan(frame.truth.left(0, 0)));
  EXPECT_EQ(frame.truth.nonoccluded(3, 4), 0);
  EXPECT_EQ(frame.truth.nonoccluded(3, 5), 255);
  folder.WriteImage("mask0nocc.png", cv::Mat1b(10, 30, uint8_t{255}));
  EXPECT_THAT(OpenError(folder.Config()), HasSubstr("mask0nocc.png: 30x10 px; allowed: 30x20"));
}

// One pixel of the scan, 10 m before the left camera; f = 100 px, b = 0.5 m.
class KittiLayouts : public testing::Test {
 protected:
  void WriteViews(const std::string& left, const std::string& right) const {
    for (const std::string& view : {left, right}) {
      std::filesystem::create_directories(folder_.File(view));
      for (const char* name : {"/0000000000.png", "/0000000001.png"}) {
        folder_.WriteImage(view + name, SomePicture(kSize));
      }
    }
  }

  void WriteScan(const std::string& scans, float x) const {
    std::filesystem::create_directories(folder_.File(scans));
    const float point[4] = {x, 0, 0, 0};
    for (const char* name : {"/0000000000.bin", "/0000000001.bin"}) {
      folder_.WriteText(scans + name, {reinterpret_cast<const char*>(point), sizeof point});
    }
  }

  std::unique_ptr<Dataset> Open(const std::string& rest) const {
    return OpenDataset("kitti:" + folder_.File(rest));
  }

  SceneFolder folder_;
};

TEST_F(KittiLayouts, OdometrySequencesHaveOneCalibration) {
  WriteViews("image_2", "image_3");
  WriteScan("velodyne", 8);
  folder_.WriteText("calib.txt",
                    "P0: 100 0 20 0 0 100 15 0 0 0 1 0\nP1: 100 0 20 -54 0 100 15 0 0 0 1 0\n"
                    "P2: 100 0 20 6 0 100 15 0 0 0 1 0\nP3: 100 0 20 -44 0 100 15 0 0 0 1 0\n"
                    "Tr: 0 -1 0 -0.06 0 0 -1 0 1 0 0 2\n");
  const auto source = Open("");
  EXPECT_EQ(source->frame_count(), 2);
  EXPECT_NEAR(source->rig().pair.baseline_m, 0.5, 1e-12);
  const DatasetFrame frame = source->Get(1);
  EXPECT_NEAR(frame.tof.depth_m(15, 20), 10, 1e-5);
  EXPECT_TRUE(frame.truth.left.empty());
  EXPECT_EQ(Open("0000000001")->frame_count(), 1);
}

TEST_F(KittiLayouts, OdometrySequencesMayHaveGreyImagesAlone) {
  WriteViews("image_0", "image_1");
  folder_.WriteText("calib.txt",
                    "P0: 100 0 20 0 0 100 15 0 0 0 1 0\nP1: 100 0 20 -54 0 100 15 0 0 0 1 0\n");
  const auto source = Open("?tof=none");
  EXPECT_NEAR(source->rig().pair.baseline_m, 0.54, 1e-12);
  EXPECT_EQ(source->frame_count(), 2);
}

// As they are published: without scans.
TEST_F(KittiLayouts, StereoSetsHaveAPairAndItsTruthAlone) {
  const auto write = [&](const std::vector<std::string>& images, const std::string& truth,
                         const std::string& calibration, const std::string& text) {
    for (const std::string& folder : {images[0], images[1], truth, calibration}) {
      std::filesystem::create_directories(folder_.File(folder));
    }
    for (const std::string& view : images) {
      folder_.WriteImage(view + "/000000_10.png", SomePicture(kSize));
    }
    folder_.WriteImage(truth + "/000000_10.png", cv::Mat1w(kSize, uint16_t{5 * 256}));
    folder_.WriteText(calibration + "/000000.txt", text);
  };
  write({"2012/image_0", "2012/image_1"}, "2012/disp_occ", "2012/calib",
        "P0: 100 0 20 0 0 100 15 0 0 0 1 0\nP1: 100 0 20 -54 0 100 15 0 0 0 1 0\n"
        "P2: 100 0 20 6 0 100 15 0 0 0 1 0\nP3: 100 0 20 -44 0 100 15 0 0 0 1 0\n");
  write({"2015/image_2", "2015/image_3"}, "2015/disp_occ_0", "2015/calib_cam_to_cam",
        "P_rect_02: 100 0 20 6 0 100 15 0 0 0 1 0\nP_rect_03: 100 0 20 -44 0 100 15 0 0 0 1 0\n");
  for (const auto& [name, baseline_m] : {std::pair{"2012", 0.54}, {"2015", 0.5}}) {
    const auto source = Open(std::string(name) + "?tof=none");
    EXPECT_NEAR(source->rig().pair.baseline_m, baseline_m, 1e-12);
    EXPECT_EQ(source->Get(0).truth.left(5, 5), 5);
    CaptureConfig with_scan;
    with_scan.set_source("kitti:" + folder_.File(name));
    EXPECT_THAT(OpenError(with_scan), HasSubstr("000000.bin: not there; allowed: that of a "
                                                "Velodyne, or ?tof=none"));
  }
}

TEST_F(KittiLayouts, RawDrivesHaveTheirDaysCalibrationInTheFolderAbove) {
  WriteViews("drive_sync/image_02/data", "drive_sync/image_03/data");
  WriteScan("drive_sync/velodyne_points/data", 8);
  folder_.WriteText("calib_cam_to_cam.txt",
                    "calib_time: 09-Jan-2012 13:57:47\nR_rect_00: 1 0 0 0 1 0 0 0 1\n"
                    "P_rect_00: 100 0 20 0 0 100 15 0 0 0 1 0\n"
                    "P_rect_01: 100 0 20 -54 0 100 15 0 0 0 1 0\n"
                    "P_rect_02: 100 0 20 6 0 100 15 0 0 0 1 0\n"
                    "P_rect_03: 100 0 20 -44 0 100 15 0 0 0 1 0\n");
  folder_.WriteText("calib_velo_to_cam.txt", "R: 0 -1 0 0 0 -1 1 0 0\nT: -0.06 0 2\n");
  const auto source = Open("drive_sync");
  EXPECT_EQ(source->frame_count(), 2);
  EXPECT_NEAR(source->rig().pair.baseline_m, 0.5, 1e-12);
  EXPECT_NEAR(source->Get(0).tof.depth_m(15, 20), 10, 1e-5);
  // --calib of sprout-pipeline files reads the same file.
  EXPECT_NEAR(OpenCalibFile(folder_.File("calib_cam_to_cam.txt"))(kSize, true).baseline_m, 0.54,
              1e-12);
  // KITTI-360's one pair is in colour.
  folder_.WriteText("perspective.txt",
                    "P_rect_00: 100 0 20 0 0 100 15 0 0 0 1 0\nR_rect_01: 1 0 0 0 1 0 0 0 1\n"
                    "P_rect_01: 100 0 20 -59 0 100 15 0 0 0 1 0\n");
  EXPECT_NEAR(OpenCalibFile(folder_.File("perspective.txt"))(kSize, false).baseline_m, 0.59, 1e-12);
}

}  // namespace
}  // namespace sprout::scenes
