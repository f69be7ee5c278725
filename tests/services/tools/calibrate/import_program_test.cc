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

TEST_F(ImportProgram, LengthsInMillimetresAreNotTakenForMetres) {
  ImportOptions options = Options(Camchain(1000));
  testing::internal::CaptureStdout();
  EXPECT_THAT(Refusal(options), HasSubstr("the cameras are 120 m apart, if the file is in m"));
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
  EXPECT_THAT(Refusal(options), HasSubstr("the cameras are 0.00012 m apart, if the file is in mm"));
  testing::internal::GetCapturedStdout();
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
