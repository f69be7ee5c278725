#include <fmt/core.h>
#include <gmock/gmock.h>

#include <fstream>

#include "common/config/config_error.h"
#include "common/rig/rig_file.h"
#include "services/tools/calibrate/import/import.h"
#include "tests/common/picture/temporary_directory.h"
#include "tests/common/testing/thrown.h"

namespace sprout::calibrate {
namespace {

using testing::HasSubstr;

// Kalibr's, 120 mm apart; lengths are multiplied by `scale`.
std::string Camchain(double scale) {
  const std::string camera =
      "  camera_model: pinhole\n  distortion_coeffs: [-0.28, 0.07, 0.0001, -0.0002]\n"
      "  distortion_model: radtan\n  intrinsics: [500, 501, 322, 241]\n"
      "  resolution: [640, 480]\n";
  return "cam0:\n" + camera + "cam1:\n" + camera + "  T_cn_cnm1:\n  - [1, 0, 0, " +
         std::to_string(-0.12 * scale) +
         "]\n  - [0, 1, 0, 0]\n  - [0, 0, 1, 0]\n  - [0, 0, 0, 1]\n";
}

class ImportProgram : public testing::Test {
 protected:
  ImportOptions Options(const std::string& text) const {
    std::ofstream(folder_ / "file.yaml") << text;
    return {.files = {folder_ / "file.yaml"}, .out = folder_ / "rig.textproto"};
  }

  static std::string Refusal(const ImportOptions& options) {
    return Thrown<ConfigError>([&] { RunImport(options); });
  }

  const TemporaryDirectory folder_;
};

TEST_F(ImportProgram, MakesARigFileAndKeepsTheDevices) {
  RigDescription devices;
  devices.mutable_left()->set_serial("42");
  ASSERT_TRUE(SaveRigFile(folder_ / "devices.textproto", devices));
  ImportOptions options = Options(Camchain(1));
  options.rig = folder_ / "devices.textproto";
  testing::internal::CaptureStdout();
  EXPECT_EQ(RunImport(options), 0);
  const std::string out = testing::internal::GetCapturedStdout();
  EXPECT_THAT(out, HasSubstr("cam0: 640x480 px, f 500.00, 501.00 px, principal point 322.00, "));
  EXPECT_THAT(out, HasSubstr("right camera in the left one's frame: 0.12000, "));
  const RigDescription rig = LoadRigFile(options.out);
  EXPECT_EQ(rig.left().serial(), "42");
  const RawRig raw = RequireCalibration(rig, options.out);
  EXPECT_EQ(raw.left.distortion, (std::array<double, 5>{-0.28, 0.07, 0.0001, -0.0002, 0}));
  EXPECT_NEAR(raw.left_from_right.translation_m.x(), 0.12, 1e-9);
}

// ROS's, of which left.yaml is of an earlier calibration.
TEST_F(ImportProgram, FilesOfTwoCalibrationsAreRefused) {
  const auto write = [&](const char* name, double focal_px, double tx) {
    std::ofstream(folder_ / name) << fmt::format(
        "image_width: 640\nimage_height: 480\ndistortion_model: plumb_bob\n"
        "camera_matrix: {{data: [500, 0, 320, 0, 500, 240, 0, 0, 1]}}\n"
        "distortion_coefficients: {{data: [0, 0, 0, 0, 0]}}\n"
        "rectification_matrix: {{data: [1, 0, 0, 0, 1, 0, 0, 0, 1]}}\n"
        "projection_matrix: {{data: [{0}, 0, 320, {1}, 0, {0}, 240, 0, 0, 0, 1, 0]}}\n",
        focal_px, tx);
    return folder_ / name;
  };
  ImportOptions options{.files = {write("left.yaml", 500, 0), write("right.yaml", 500.1, -60)},
                        .out = folder_ / "rig.textproto"};
  testing::internal::CaptureStdout();
  EXPECT_EQ(RunImport(options), 0);
  testing::internal::GetCapturedStdout();
  write("right.yaml", 510, -61.2);
  EXPECT_THAT(Refusal(options), HasSubstr("right.yaml: projection_matrix has f = 510 and cy = 240 "
                                          "px, that of the left one 500 and 240: are both"));
}

TEST_F(ImportProgram, LengthsInMillimetresAreNotTakenForMetres) {
  ImportOptions options = Options(Camchain(1000));
  testing::internal::CaptureStdout();
  EXPECT_THAT(Refusal(options),
              HasSubstr("the cameras are 120 m apart, if the unit of the file is m"));
  options.unit = "mm";
  EXPECT_EQ(RunImport(options), 0);
  testing::internal::GetCapturedStdout();
  const RawRig raw = RequireCalibration(LoadRigFile(options.out), options.out);
  EXPECT_NEAR(raw.left_from_right.translation_m.x(), 0.12, 1e-9);
}

TEST_F(ImportProgram, LengthsInMetresAreNotTakenForMillimetres) {
  ImportOptions options = Options(Camchain(1));
  options.unit = "mm";
  testing::internal::CaptureStdout();
  EXPECT_THAT(Refusal(options),
              HasSubstr("the cameras are 0.00012 m apart, if the unit of the file is mm"));
  testing::internal::GetCapturedStdout();
}

// As `ros2 topic echo --once` prints them, and, in capitals, ROS 1's `rostopic echo -n 1`.
TEST_F(ImportProgram, CameraInfosOfTopicEcho) {
  const auto echo = [](const std::string& names, const std::string& tx) {
    const auto field = [&](size_t i, const std::string& numbers) {
      return names.substr(i, 1) + ": [" + numbers + "]\n";
    };
    return "header:\n  stamp:\n    sec: 1\n  frame_id: left\nheight: 480\nwidth: 640\n"
           "distortion_model: plumb_bob\n" +
           field(0, "-0.28, 0.07, 0, 0, 0") + field(1, "500, 0, 322, 0, 501, 241, 0, 0, 1") +
           field(2, "1, 0, 0, 0, 1, 0, 0, 0, 1") +
           field(3, "510, 0, 320, " + tx + ", 0, 510, 240, 0, 0, 0, 1, 0") + "binning_x: 0\n---\n";
  };
  for (const char* names : {"dkrp", "DKRP"}) {
    ImportOptions options = Options(echo(names, "0"));
    options.files.push_back(folder_ / "right.yaml");
    std::ofstream(options.files[1]) << echo(names, "-61.2");
    testing::internal::CaptureStdout();
    EXPECT_EQ(RunImport(options), 0);
    testing::internal::GetCapturedStdout();
    const RawRig raw = RequireCalibration(LoadRigFile(options.out), options.out);
    EXPECT_NEAR(raw.left_from_right.translation_m.x(), 0.12, 1e-9);
    EXPECT_EQ(raw.left.width, 640);
  }
}

// Calibrated with squares of side 1.
TEST_F(ImportProgram, LengthsInSquaresOfABoard) {
  ImportOptions options = Options(Camchain(1 / 0.025));
  testing::internal::CaptureStdout();
  EXPECT_THAT(Refusal(options), HasSubstr("the cameras are 4.8 m apart, if the unit of the file"));
  options.unit = "25mm";
  EXPECT_THAT(Refusal(options), HasSubstr("--unit 25mm; allowed: --unit mm, cm, m, or metres ("));
  options.unit = "0.025";
  EXPECT_EQ(RunImport(options), 0);
  testing::internal::GetCapturedStdout();
  const RawRig raw = RequireCalibration(LoadRigFile(options.out), options.out);
  EXPECT_NEAR(raw.left_from_right.translation_m.x(), 0.12, 1e-9);
}

TEST_F(ImportProgram, NamesTheProgramWhoseFilesAreNotRead) {
  const std::pair<const char*, const char*> kCases[] = {
      {"[LEFT_CAM_HD]\nfx=700\n", "file.yaml: a .conf of ZED; the images of its SDK are rectified"},
      {"{\"fx\": 1, \"ppx\": 2}", "a RealSense; the images of its SDK are rectified"},
      {"#   CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n1 OPENCV 752 480 458\n",
       "COLMAP's cameras, which do not say how a pair stands; allowed are OpenCV's"},
      {"%YAML:1.0\nimu: 1\ncam0_calib: \"cam0.yaml\"\n", "the settings of VINS, whose cameras"},
      {"# oST version 5.0 parameters\n", "ROS's ost.txt; left.yaml and right.yaml of the same"},
      {"cam0=[4000 0 1; 0 4000 2; 0 0 1]\n", "sprout-pipeline files --calib reads it"}};
  for (const auto& [text, answer] : kCases) {
    EXPECT_THAT(Refusal(Options(text)), HasSubstr(answer));
  }
}

TEST_F(ImportProgram, RefusesSizesThatCannotBe) {
  ImportOptions options = Options(Camchain(1));
  options.size = "640";
  EXPECT_THAT(Refusal(options), HasSubstr("--size 640: allowed is WIDTHxHEIGHT"));
  options.size = "320x240";
  EXPECT_THAT(Refusal(options), HasSubstr("--size 320x240: the file says 640x480"));
  EXPECT_FALSE(std::filesystem::exists(options.out));
}

}  // namespace
}  // namespace sprout::calibrate
