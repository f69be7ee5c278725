#include "common/rig/rig_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <string>

#include "common/config/config_error.h"
#include "common/rig/rectifier.h"
#include "tests/common/picture/temporary_directory.h"
#include "tests/common/rig/tilted_rig.h"

namespace sprout {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class RigFile : public ::testing::Test {
 protected:
  std::string Write(const std::string& text) const {
    std::ofstream(path_) << text;
    return text;
  }

  std::string Error() const {
    try {
      RequireCalibration(LoadRigFile(path_), path_);
      return "no error";
    } catch (const ConfigError& e) {
      return e.what();
    }
  }

  // Of the tilted rig with one change.
  std::string ErrorAfter(const std::function<void(RawRig&)>& change) const {
    RawRig rig = TiltedRig();
    change(rig);
    RigDescription description;
    *description.mutable_calibration() = ToCalibration(rig);
    EXPECT_TRUE(SaveRigFile(path_, description));
    return Error();
  }

  TemporaryDirectory folder_;
  std::string path_ = folder_ / "rig.textproto";
};

TEST_F(RigFile, KeepsEveryNumberOfACalibration) {
  const RawRig rig = TiltedRig();
  RigDescription written;
  written.mutable_left()->set_serial("A17");
  written.set_trigger(RigDescription::LINE);
  *written.mutable_calibration() = ToCalibration(rig);
  ASSERT_TRUE(SaveRigFile(path_, written));

  const RigDescription read = LoadRigFile(path_);
  EXPECT_EQ(read.left().serial(), "A17");
  EXPECT_EQ(read.trigger(), RigDescription::LINE);
  const RawRig again = RequireCalibration(read, path_);
  EXPECT_EQ(RigId(Rectifier(again).rig()), RigId(Rectifier(rig).rig()));
  EXPECT_EQ(again.range_scale, rig.range_scale);
  EXPECT_EQ(again.range_offset_m, rig.range_offset_m);
  EXPECT_EQ(again.right.distortion, rig.right.distortion);
}

TEST_F(RigFile, MayHaveNoCalibrationYet) {
  Write("left { serial: '1' }");
  EXPECT_FALSE(CalibrationOf(LoadRigFile(path_)));
  EXPECT_THAT(Error(), AllOf(HasSubstr(path_), HasSubstr("no calibration")));
}

TEST_F(RigFile, SaysWhatCannotBeRead) {
  EXPECT_THAT(Error(), AllOf(HasSubstr(path_), HasSubstr("cannot be read")));
  Write("left { serial: '1' }\nlefd {}");
  EXPECT_THAT(Error(), AllOf(HasSubstr("rig.textproto:2:"), HasSubstr("lefd")));
  Write("max_spread_ms: 0");
  EXPECT_THAT(Error(), AllOf(HasSubstr("max_spread_ms = 0"), HasSubstr("allowed: 0.001 to 1000")));
}

TEST_F(RigFile, NamesTheFieldThatCannotBeUsed) {
  EXPECT_THAT(ErrorAfter([](RawRig& rig) { rig.left.fx = 0; }), HasSubstr("left.fx = 0"));
  EXPECT_THAT(ErrorAfter([](RawRig& rig) { rig.right.width = 320; }),
              HasSubstr("right.width × height = 320x480"));
  EXPECT_THAT(ErrorAfter([](RawRig& rig) { rig.left_from_right.translation_m *= -1; }),
              HasSubstr("left_from_right.translation_m x = -0.1"));
  EXPECT_THAT(ErrorAfter([](RawRig& rig) { rig.left_from_tof.rotation.w() = 2; }),
              HasSubstr("left_from_tof.rotation norm = 2"));
  EXPECT_THAT(ErrorAfter([](RawRig& rig) { rig.tof.distortion[3] = NAN; }),
              HasSubstr("tof.distortion = nan"));
  Write("calibration { left { distortion: [1, 2, 3, 4, 5, 6] } }");
  EXPECT_THAT(Error(), HasSubstr("left.distortion: 6 numbers; allowed: 5"));
  Write("calibration { left_from_right { rotation: [1, 0, 0] } }");
  EXPECT_THAT(Error(), HasSubstr("left_from_right.rotation: 3 numbers; allowed: 4"));
}

}  // namespace
}  // namespace sprout
