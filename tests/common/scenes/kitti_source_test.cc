
#include <gmock/gmock.h>

#include <cmath>

#include "tests/common/scenes/kitti_folder.h"

namespace sprout::scenes {
namespace {

using testing::AllOf;
using testing::HasSubstr;

int ScanReturns(const TofImage& tof) { return cv::countNonZero(tof.depth_m == tof.depth_m); }

TEST(KittiDataset, GivesImagesCalibrationAndTruthOfAFrame) {
  const KittiFolder folder("000007");
  const auto source = folder.Open("/000007");
  EXPECT_EQ(source->frame_count(), 1);
  const RectifiedPair& pair = source->rig().pair;
  EXPECT_EQ(pair.size(), cv::Size(40, 30));
  EXPECT_EQ(pair.focal_px, 100);
  EXPECT_EQ(pair.cx, 20);
  EXPECT_EQ(pair.cy, 15);
  EXPECT_EQ(pair.cx_right, 20);
  EXPECT_EQ(pair.baseline_m, 0.5);
  const DatasetFrame frame = source->Get(0);
  EXPECT_EQ(frame.left.type(), CV_8UC3);
  EXPECT_EQ(frame.right.size(), pair.size());
  EXPECT_EQ(frame.truth.left(4, 5), 5);
  EXPECT_TRUE(std::isnan(frame.truth.left(0, 0)));
  EXPECT_TRUE(frame.truth.right.empty());
}

TEST(KittiDataset, MakesTheScanARangeImageOfTheLeftCamera) {
  const KittiFolder folder("000007");
  const auto source = folder.Open("/000007");
  const TofCamera& camera = source->rig().tof;
  EXPECT_EQ(cv::Size(camera.width, camera.height), cv::Size(40, 30));
  EXPECT_EQ(camera.fx, 100);
  EXPECT_EQ(camera.fy, 100);
  EXPECT_EQ(camera.cx, 20);
  EXPECT_EQ(camera.cy, 15);
  EXPECT_TRUE(camera.left_from_tof_rotation.isApprox(Eigen::Quaterniond::Identity()));
  EXPECT_EQ(camera.left_from_tof_translation_m, Eigen::Vector3d::Zero());
  const TofImage tof = source->Get(0).tof;
  EXPECT_EQ(ScanReturns(tof), 2);
  EXPECT_EQ(tof.depth_m(15, 20), 10);
  EXPECT_EQ(tof.depth_m(25, 15), 20);
  EXPECT_TRUE(tof.amplitude.empty());
}

TEST(KittiDataset, KeepsTheNearestPointOfAPixel) {
  const KittiFolder folder("000007");
  folder.WriteScan("000007", {{12, 0, 0, 0}, {10, 0, 0, 0}, {11, 0, 0, 0}});
  EXPECT_EQ(folder.Open("/000007")->Get(0).tof.depth_m(15, 20), 10);
}

TEST(KittiDataset, PlacesTheScannerAsTheCalibrationSays) {
  const KittiFolder folder("000007");
  // 2 m before the left camera, which stands 0.1 m to the left of, and 0.01 m behind, camera 0.
  folder.WriteCalibration("000007", "Tr_velo_to_cam", "0 -1 0 0 0 0 -1 0 1 0 0 1.99");
  const std::string calib =
      "P2: 100 0 20 10.2 0 100 15 0.15 0 0 1 0.01\n"
      "P3: 100 0 20 -39.8 0 100 15 0.15 0 0 1 0.01\n"
      "R0_rect: 1 0 0 0 1 0 0 0 1\n"
      "Tr_velo_to_cam: 0 -1 0 0 0 0 -1 0 1 0 0 1.99\n";
  folder.files().WriteText("calib/000007.txt", calib);
  folder.WriteScan("000007", {{8, 0.1F, 0, 0}});
  const auto source = folder.Open("/000007");
  EXPECT_NEAR(source->rig().pair.baseline_m, 0.5, 1e-12);
  EXPECT_NEAR(source->Get(0).tof.depth_m(15, 20), 10, 1e-5);
}

TEST(KittiDataset, KeepsEveryFourthOf64Beams) {
  const KittiFolder folder;
  folder.WriteObject("000007");
  std::vector<KittiFolder::Point> points;
  for (int beam = 0; beam < 64; ++beam) {
    const double elevation = (2 - (beam + 0.5) * 26.9 / 64) * M_PI / 180;
    const double y = 0.3 * (beam - 12);  // a column of its own for each
    const double z = std::hypot(20, y) * std::tan(elevation);
    points.push_back({20, static_cast<float>(y), static_cast<float>(z), 0});
  }
  folder.WriteScan("000007", points);
  // The camera sees beams 0 to 23.
  EXPECT_EQ(ScanReturns(folder.Open("/000007")->Get(0).tof), 24);
  EXPECT_EQ(ScanReturns(folder.Open("/000007?beams=64")->Get(0).tof), 24);
  EXPECT_EQ(ScanReturns(folder.Open("/000007?beams=32")->Get(0).tof), 12);
  EXPECT_EQ(ScanReturns(folder.Open("/000007?beams=16")->Get(0).tof), 6);
  EXPECT_EQ(ScanReturns(folder.Open("/000007?beams=8")->Get(0).tof), 3);
  EXPECT_EQ(ScanReturns(folder.Open("/000007?beams=4")->Get(0).tof), 1);
}

TEST(KittiDataset, LeavesTheScanOutOnDemand) {
  const KittiFolder folder("000007");
  folder.files().Remove("velodyne/000007.bin");
  const auto source = folder.Open("/000007?tof=none");
  EXPECT_EQ(source->rig().tof.width, 0);
  EXPECT_EQ(source->rig().tof.height, 0);
  EXPECT_TRUE(source->Get(0).tof.depth_m.empty());
}

TEST(KittiDataset, TakesWhatBothCamerasSeeFromItsOwnTruth) {
  const KittiFolder folder("000007");
  const cv::Mat1b all = folder.Open("/000007")->Get(0).truth.nonoccluded;
  EXPECT_EQ(cv::countNonZero(all), 40 * 30 - 1);
  cv::Mat1w seen(30, 40, uint16_t{5 * 256});
  seen(cv::Rect(0, 0, 40, 1)) = 0;
  folder.WriteTruth("disp_noc_0/000007_10.png", seen);
  EXPECT_EQ(cv::countNonZero(folder.Open("/000007")->Get(0).truth.nonoccluded), 40 * 29);
  folder.files().Remove("disp_occ_0/000007_10.png");
  const GroundTruth truth = folder.Open("/000007")->Get(0).truth;
  EXPECT_TRUE(std::isnan(truth.left(0, 1)));
  EXPECT_EQ(truth.left(1, 1), 5);
}

TEST(KittiDataset, ReadsTheObjectSet) {
  const KittiFolder folder;
  folder.WriteObject("000123");
  const DatasetFrame frame = folder.Open("/000123")->Get(0);
  EXPECT_EQ(ScanReturns(frame.tof), 2);
  EXPECT_TRUE(frame.truth.left.empty());
}

TEST(KittiDataset, GivesAllFramesInTheOrderOfTheirNames) {
  const KittiFolder folder("000014");
  folder.WriteStereo("000007");
  folder.WriteScan("000014", {{5, 0, 0, 0}});
  folder.files().WriteImage("image_2/000007_11.png", SomePicture({40, 30}));    // no frame
  folder.files().WriteImage("image_2/._000007_10.png", SomePicture({40, 30}));  // nor is this
  for (const std::string rest : {"", "/", "?beams=64"}) {
    const auto source = folder.Open(rest);
    EXPECT_EQ(source->frame_count(), 2);
    EXPECT_EQ(source->Get(1).tof.depth_m(15, 20), 5);
    EXPECT_EQ(source->Get(0).tof.depth_m(15, 20), 10);
  }
}

TEST(KittiDataset, RefusesASequenceOfTwoCalibrations) {
  const KittiFolder folder;
  folder.WriteObject("1");
  folder.WriteObject("2");
  folder.WriteCalibration("2", "P3", "100 0 20 -51 0 100 15 0 0 0 1 0");
  EXPECT_THAT(OpenError(folder.Config("")),
              AllOf(HasSubstr("calib/2.txt: not that of"), HasSubstr("calib/1.txt"),
                    HasSubstr("kitti:FOLDER/ID")));
  EXPECT_EQ(folder.Open("/2")->frame_count(), 1);
}

TEST(KittiErrors, SaysHowAFrameIsNamed) {
  const KittiFolder folder("000007");
  for (const std::string rest : {"/000008", "x", "/000007_10.png"}) {
    EXPECT_THAT(OpenError(folder.Config(rest)),
                AllOf(HasSubstr("capture.source = kitti:"), HasSubstr("no such frame"),
                      HasSubstr("FOLDER or FOLDER/ID")))
        << rest;
  }
  const KittiFolder empty;
  EXPECT_THAT(OpenError(empty.Config("")), HasSubstr("no frame"));
}

TEST(KittiErrors, NamesTheFileThatIsMissing) {
  for (const std::string name :
       {"image_3/000007_10.png", "calib/000007.txt", "velodyne/000007.bin"}) {
    const KittiFolder folder("000007");
    folder.files().Remove(name);
    EXPECT_THAT(OpenError(folder.Config("/000007")), HasSubstr(name));
  }
}

TEST(KittiErrors, NamesImagesThatDoNotFit) {
  const KittiFolder folder("000007");
  folder.files().WriteImage("image_3/000007_10.png", SomePicture({40, 31}));
  EXPECT_THAT(OpenError(folder.Config("/000007")),
              AllOf(HasSubstr("image_3/000007_10.png"), HasSubstr("40x31"), HasSubstr("40x30")));
  folder.WriteStereo("000007");
  folder.WriteTruth("disp_occ_0/000007_10.png", cv::Mat1w(29, 40, uint16_t{256}));
  EXPECT_THAT(OpenError(folder.Config("/000007")),
              AllOf(HasSubstr("disp_occ_0/000007_10.png"), HasSubstr("40x29")));
  folder.files().WriteImage("disp_occ_0/000007_10.png", cv::Mat1b(30, 40, uchar{5}));
  EXPECT_THAT(OpenError(folder.Config("/000007")),
              AllOf(HasSubstr("disp_occ_0/000007_10.png"), HasSubstr("16-bit")));
}

// As of clouds that keep their rows.
TEST(KittiDataset, LeavesOutPointsWithoutAReturn) {
  const KittiFolder folder("000007");
  const float nan = std::nanf("");
  folder.WriteScan("000007", {{nan, nan, nan, 0}, {10, 0, 0, 0}, {nan, nan, nan, nan}});
  const cv::Mat1f depth_m = OpenDataset(folder.Config("/000007"))->Get(0).tof.depth_m;
  EXPECT_EQ(cv::countNonZero(depth_m > 0), 1);
}

TEST(KittiErrors, RefusesAScanThatIsBroken) {
  const KittiFolder folder("000007");
  const auto error = [&](const std::string& bytes) {
    folder.files().WriteText("velodyne/000007.bin", bytes);
    return OpenError(folder.Config("/000007"));
  };
  EXPECT_THAT(error(""), AllOf(HasSubstr("velodyne/000007.bin: empty"), HasSubstr("16 bytes")));
  EXPECT_THAT(error(std::string(31, '\0')), HasSubstr("ends within a point, at byte 31"));
  EXPECT_THAT(error(std::string(32, '\xff')), HasSubstr("all points are NaN"));
  const float nan = std::nanf("");
  folder.WriteScan("000007", {{nan, 0, 0, 0}, {10, 0, 0, 0}});
  EXPECT_THAT(OpenError(folder.Config("/000007")), HasSubstr("point 1 is out of range"));
  folder.WriteScan("000007", {{10, 0, 0, 0}, {1e30F, 0, 0, 0}});
  EXPECT_THAT(OpenError(folder.Config("/000007")), HasSubstr("point 2 is out of range"));
  folder.WriteScan("000007", {{-10, 0, 0, 0}, {10, 10, 0, 0}});
  EXPECT_THAT(OpenError(folder.Config("/000007")), HasSubstr("no point falls into the left image"));
}

TEST(KittiErrors, RefusesOptionsThatItDoesNotHave) {
  const KittiFolder folder("000007");
  for (const std::string beams : {"", "0", "15", "65", "-16", "x", "16.0"}) {
    EXPECT_THAT(OpenError(folder.Config("/000007?beams=" + beams)),
                AllOf(HasSubstr("capture.beams = "), HasSubstr("allowed: 64, 32, 16, 8")));
  }
  EXPECT_THAT(OpenError(folder.Config("/000007?tof=sr4000")), HasSubstr("a scan of its own"));
  EXPECT_THAT(OpenError(folder.Config("/000007?beams=16&zoom=2")),
              AllOf(HasSubstr("no such option zoom=2"), HasSubstr("beams=64, 32, 16, 8 or 4")));
  CaptureConfig middlebury;
  middlebury.set_source("middlebury:/no/folder?beams=16");
  EXPECT_THAT(OpenError(middlebury), HasSubstr("no such option beams=16"));
}

struct KittiCalibCase {
  std::string key;
  std::string value;
  std::string message;
};

void PrintTo(const KittiCalibCase& broken, std::ostream* out) {
  *out << broken.key << " = '" << broken.value << "'";
}

class KittiCalib : public testing::TestWithParam<KittiCalibCase> {};

TEST_P(KittiCalib, IsRefusedWithKeyAndReason) {
  const KittiCalibCase& c = GetParam();
  const KittiFolder folder("000007");
  folder.WriteCalibration("000007", c.key, c.value);
  EXPECT_THAT(OpenError(folder.Config("/000007")),
              AllOf(HasSubstr("calib/000007.txt"), HasSubstr(c.key), HasSubstr(c.message)));
}

INSTANTIATE_TEST_SUITE_P(
    Broken, KittiCalib,
    testing::Values(KittiCalibCase{"P2", "", "P2 is missing"},
                    KittiCalibCase{"P3", "1\nP3: 1", "P3 is given more than once"},
                    KittiCalibCase{"P3", "", "P3 is missing"},
                    KittiCalibCase{"R0_rect", "", "R0_rect is missing"},
                    KittiCalibCase{"Tr_velo_to_cam", "", "Tr_velo_to_cam is missing"},
                    KittiCalibCase{"P2", "100 0 20 0 0 100 15 0 0 0 1", "12 finite numbers"},
                    KittiCalibCase{"P2", "100 0 20 0 0 100 15 0 0 0 1 0 0", "12 finite numbers"},
                    KittiCalibCase{"P2", "x 0 20 0 0 100 15 0 0 0 1 0", "12 finite numbers"},
                    KittiCalibCase{"P2", "100 0 nan 0 0 100 15 0 0 0 1 0", "12 finite numbers"},
                    KittiCalibCase{"P2", "0 0 20 0 0 0 15 0 0 0 1 0", "a focal length above 0"},
                    KittiCalibCase{"P3", "101 0 20 -50 0 101 15 0 0 0 1 0", "one focal length"},
                    KittiCalibCase{"P3", "100 0 20 -50 0 100 16 0 0 0 1 0", "P2's row"},
                    KittiCalibCase{"P3", "100 0 20 0 0 100 15 0 0 0 1 0", "to the right"},
                    KittiCalibCase{"R0_rect", "1 0 0 0 1 0 0 0 2", "a rotation"},
                    KittiCalibCase{"Tr_velo_to_cam", "1 0 0 0 0 1 0 0 0 0 -1 0", "a rotation"}));

}  // namespace
}  // namespace sprout::scenes
