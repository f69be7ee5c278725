#include "common/rig/rig_file.h"

#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <numbers>
#include <sstream>

#include "common/config/config_error.h"
#include "common/core/read_text.h"
#include "common/rig/rectifier.h"
#include "tests/common/picture/temporary_directory.h"
#include "tests/common/rig/tilted_rig.h"
#include "tests/common/testing/thrown.h"

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
    return Thrown<ConfigError>([&] { RequireCalibration(LoadRigFile(path_), path_); });
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

TEST_F(RigFile, HasTheBoardsCalibrationBesideOneThatWasPutRight) {
  RigDescription rig;
  EXPECT_FALSE(BoardCalibrationOf(rig));
  *rig.mutable_calibration() = ToCalibration(TiltedRig());
  EXPECT_EQ(BoardCalibrationOf(rig)->range_offset_m, TiltedRig().range_offset_m);
  RawRig board = TiltedRig();
  board.range_offset_m = 0.125;
  *rig.mutable_board_calibration() = ToCalibration(board);
  EXPECT_EQ(BoardCalibrationOf(rig)->range_offset_m, 0.125);
  EXPECT_EQ(CalibrationOf(rig)->range_offset_m, TiltedRig().range_offset_m);
  rig.mutable_board_calibration()->mutable_right()->set_fx(-1);
  EXPECT_THAT(Thrown<ConfigError>([&] { BoardCalibrationOf(rig); }),
              HasSubstr("board_calibration.right.fx = -1"));
}

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
  EXPECT_TRUE(again.range_correction.empty());
}

TEST_F(RigFile, KeepsTheCorrectionOfTheRanges) {
  RawRig rig = TiltedRig();
  rig.range_correction = {{0.5, 0.012, 0.001}, {1.25, -0.003, 0.002}, {4, 0.02, 0.01}};
  rig.amplitude_correction = {-0.012, 0.002, 474.5};
  RigDescription written;
  *written.mutable_calibration() = ToCalibration(rig);
  ASSERT_TRUE(SaveRigFile(path_, written));
  const RawRig again = RequireCalibration(LoadRigFile(path_), path_);
  EXPECT_EQ(again.range_correction, rig.range_correction);
  EXPECT_EQ(again.amplitude_correction, rig.amplitude_correction);
}

TEST_F(RigFile, RefusesACorrectionThatCannotBe) {
  const auto error_of = [&](const RangeCorrection& correction) {
    return ErrorAfter([&](RawRig& rig) { rig.range_correction = correction; });
  };
  EXPECT_THAT(error_of({{1, 0, 0}, {1, 0, 0}}), HasSubstr("range_correction[1].range_m = 1"));
  EXPECT_THAT(error_of({{1, 0, 0}, {2, -1.5, 0}}),
              HasSubstr("range_correction[1].offset_m = -1.5"));
  EXPECT_THAT(error_of({{-1, 0, 0}}), HasSubstr("range_correction[0].range_m = -1"));
  EXPECT_THAT(error_of({{1, NAN, 0}}), HasSubstr("range_correction[0].offset_m"));
  EXPECT_THAT(error_of({{1, 0, -1}}), HasSubstr("range_correction[0].sigma_m = -1"));
  RangeCorrection long_one;
  for (int i = 0; i < 65; ++i) long_one.push_back({1.0 + i, 0, 0});
  EXPECT_THAT(error_of(long_one), HasSubstr("range_correction: knots = 65"));
  const auto light_error = [&](const AmplitudeCorrection& light) {
    return ErrorAfter([&](RawRig& rig) { rig.amplitude_correction = light; });
  };
  EXPECT_THAT(light_error({0.01, 0, 0}), HasSubstr("amplitude_correction.middle = 0"));
  EXPECT_THAT(light_error({0, 0, -1}), HasSubstr("amplitude_correction.middle = -1"));
  EXPECT_THAT(light_error({NAN, 0, 1}), HasSubstr("amplitude_correction.offset_m"));
}

TEST_F(RigFile, MayHaveNoCalibrationYet) {
  Write("left { serial: '1' }");
  EXPECT_FALSE(CalibrationOf(LoadRigFile(path_)));
  EXPECT_THAT(Error(), AllOf(HasSubstr(path_), HasSubstr("no calibration")));
}

TEST_F(RigFile, KeepsTheCommentsOfTheFileThatItReplaces) {
  std::ofstream(path_)
      << "# calibrated on the bench\n  # by A.\nleft { serial: '#\\'7' } # the new one\n";
  const RigDescription rig = LoadRigFile(path_);
  for (int i = 0; i < 2; ++i) {
    ASSERT_TRUE(SaveRigFile(path_, rig));
    EXPECT_EQ(LoadRigFile(path_).left().serial(), "#'7");
    const std::string text = *ReadText(path_);
    EXPECT_TRUE(
        text.starts_with("# calibrated on the bench\n# by A.\n"
                         "# left { serial: '#\\'7' } # the new one\nleft {"))
        << text;
  }
}

TEST_F(RigFile, TakesThePlaceOfAFileOfAnything) {
  std::ofstream(path_) << std::string("\0#\1 \xff\n", 6);
  ASSERT_TRUE(SaveRigFile(path_, {}));
  EXPECT_FALSE(LoadRigFile(path_).has_left());
}

TEST_F(RigFile, MayBeginWithAByteOrderMark) {
  RigDescription rig;
  rig.mutable_left()->set_serial("42");
  ASSERT_TRUE(SaveRigFile(path_, rig));
  Write("\xef\xbb\xbf" + FileText(path_));
  EXPECT_EQ(LoadRigFile(path_).left().serial(), "42");
}

TEST_F(RigFile, OfAnotherProgramSaysWhatMakesOneOfIt) {
  for (const char* text :
       {"%YAML:1.0\n---\nM1: 3\n", "<?xml version=\"1.0\"?>\n", "image_width: 3\ncamera_matrix:\n",
        "cam0:\n  camera_model: pinhole\n", "sensor_type: camera\nT_BS:\n  cols: 4\n",
        "[LEFT_CAM_HD]\nfx=700\n", "{\"ppx\": 320}", "cam0=[700 0 320; 0 700 240; 0 0 1]\n"}) {
    Write(text);
    EXPECT_THAT(Error(), HasSubstr("the calibration of another program; sprout-calibrate import"));
  }
}

TEST_F(RigFile, SaysWhatCannotBeRead) {
  EXPECT_THAT(Error(), AllOf(HasSubstr(path_), HasSubstr("cannot be read")));
  Write("left { serial: '1' }\nlefd {}");
  EXPECT_THAT(Error(), AllOf(HasSubstr("rig.textproto:2:"), HasSubstr("lefd")));
  Write("max_spread_ms: 0");
  EXPECT_THAT(Error(), AllOf(HasSubstr("max_spread_ms = 0"), HasSubstr("allowed: 0.001 to 1000")));
}

// The tilted rig's rectification turns the left camera: whatever is told in its frame turns with
// it.
TEST_F(RigFile, PlacesOtherCamerasAndTheRobotInTheRectifiedFrame) {
  const RawRig rig = TiltedRig();
  RigDescription description;
  *description.mutable_calibration() = ToCalibration(rig);
  OtherCamera& other = *description.add_others();
  other.set_name("like the ToF camera");
  *other.mutable_lens() = description.calibration().tof();
  *other.mutable_pose() = description.calibration().left_from_tof();
  RigPose& base = *description.mutable_base_from_left();
  for (const double value : {0.5, -0.5, 0.5, -0.5}) base.add_rotation(value);
  for (const double value : {1, 2, 3}) base.add_translation_m(value);
  const RigPlaces places = PlacesOf(description, path_);
  const Rig rectified = Rectifier(rig).rig();
  ASSERT_EQ(places.others.size(), 1U);
  const OtherCameraPlace& place = places.others.at("like the ToF camera");
  EXPECT_EQ(place.lens.fx, rig.tof.fx);
  EXPECT_LT(
      (place.left_from_camera.translation_m - rectified.tof.left_from_tof_translation_m).norm(),
      1e-12);
  EXPECT_LT(place.left_from_camera.rotation.angularDistance(rectified.tof.left_from_tof_rotation),
            1e-7);
  // The ToF camera in the robot's frame, over both.
  const Pose base_from_tof = *places.base_from_left * place.left_from_camera;
  const Eigen::Vector3d& t = rig.left_from_tof.translation_m;
  EXPECT_LT((base_from_tof.translation_m - Eigen::Vector3d(1 + t.z(), 2 - t.x(), 3 - t.y())).norm(),
            1e-12);
  EXPECT_EQ(places.pair->focal_px, rectified.pair.focal_px);
}

TEST_F(RigFile, MayPlaceCamerasWithoutACalibration) {
  Write(R"(others {
    name: "a" lens { width: 64 height: 48 fx: 50 fy: 50 cx: 32 cy: 24 }
    pose { translation_m: [1, 2, 3] }
  })");
  const RigPlaces places = PlacesOf(LoadRigFile(path_), path_);
  EXPECT_FALSE(places.pair || places.base_from_left);
  EXPECT_EQ(places.others.at("a").left_from_camera.translation_m, Eigen::Vector3d(1, 2, 3));
}

TEST_F(RigFile, TakesRotationsThatAreRounded) {
  for (const std::string half : {"0.707", "0.7071", "0.70711", "0.70710678118654757"}) {
    Write("base_from_left { rotation: [" + half + ", 0, " + half + ", 0] }");
    const RigPlaces places = PlacesOf(LoadRigFile(path_), path_);
    EXPECT_NEAR(places.base_from_left->rotation.w(), std::sqrt(0.5), 1e-12) << half;
  }
}

TEST_F(RigFile, NamesThePlaceThatCannotBeUsed) {
  const auto error = [&](const std::string& text) {
    Write(text);
    return Thrown<ConfigError>([&] { PlacesOf(LoadRigFile(path_), path_); });
  };
  const std::string lens = "lens { width: 64 height: 48 fx: 50 fy: 50 cx: 32 cy: 24 }";
  EXPECT_THAT(error("base_from_left { rotation: [1, 1, 0, 0] }"),
              AllOf(HasSubstr(path_), HasSubstr("base_from_left.rotation norm")));
  EXPECT_THAT(error("others { " + lens + " }"), HasSubstr("not empty, each once"));
  EXPECT_THAT(error("others { name: 'a' " + lens + " } others { name: 'a' " + lens + " }"),
              HasSubstr("each once"));
  EXPECT_THAT(error("others { name: 'a' lens { width: 64 } }"), HasSubstr("\"a\" }.lens.height"));
  EXPECT_THAT(error("others { name: 'a' " + lens + " pose { translation_m: [1] } }"),
              HasSubstr("pose.translation_m: 1 numbers; allowed: 3"));
}

TEST_F(RigFile, TakesNoPrincipalPointThatIsMissingForACorner) {
  RigDescription description;
  *description.mutable_calibration() = ToCalibration(TiltedRig());
  description.mutable_calibration()->mutable_tof()->clear_cx();
  ASSERT_TRUE(SaveRigFile(path_, description));
  EXPECT_THAT(Error(), HasSubstr("calibration.tof.cx = nan: allowed is a finite number"));
  description.mutable_calibration()->mutable_left()->clear_cy();
  ASSERT_TRUE(SaveRigFile(path_, description));
  EXPECT_THAT(Error(), HasSubstr("calibration.left.cy = nan: allowed is a finite number"));
}

TEST_F(RigFile, NamesTheFieldThatCannotBeUsed) {
  EXPECT_THAT(ErrorAfter([](RawRig& rig) { rig.left.fx = 0; }), HasSubstr("left.fx = 0"));
  EXPECT_THAT(ErrorAfter([](RawRig& rig) { rig.right.width = 320; }),
              HasSubstr("right.width × height = 320x480"));
  EXPECT_THAT(ErrorAfter([](RawRig& rig) { rig.left_from_right.translation_m *= -1; }),
              AllOf(HasSubstr("left_from_right.translation_m x = -0.1"),
                    HasSubstr("the right camera stands right of the left one")));
  EXPECT_THAT(ErrorAfter([](RawRig& rig) { rig.left_from_right.translation_m << 0.001, 0.12, 0; }),
              AllOf(HasSubstr("left_from_right.translation_m y = 0.12"),
                    HasSubstr("turn the images by 90 degrees")));
  EXPECT_THAT(ErrorAfter([](RawRig& rig) { rig.left_from_tof.rotation.w() = 2; }),
              HasSubstr("left_from_tof.rotation norm = 2"));
  EXPECT_THAT(ErrorAfter([](RawRig& rig) { rig.tof.distortion[3] = NAN; }),
              HasSubstr("tof.distortion = nan"));
  Write("calibration { left { distortion: [1, 2, 3, 4, 5, 6] } }");
  EXPECT_THAT(Error(), HasSubstr("left.distortion: 6 numbers; allowed: 5"));
  Write("calibration { left_from_right { rotation: [1, 0, 0] } }");
  EXPECT_THAT(Error(), HasSubstr("left_from_right.rotation: 3 numbers; allowed: 4"));
}

Pose TurnedBy(double degrees, const Eigen::Vector3d& axis) {
  const Eigen::AngleAxisd turn(degrees * std::numbers::pi / 180, axis);
  return {.rotation = Eigen::Quaterniond(turn), .translation_m = {0.1, 0, 0}};
}

TEST_F(RigFile, RefusesNumbersThatNoCameraHas) {
  EXPECT_THAT(ErrorAfter([](RawRig& rig) { rig.left.fx = 44718; }),
              AllOf(HasSubstr("left.fx = 44718"), HasSubstr("allowed is 32 to 32000 px")));
  EXPECT_THAT(ErrorAfter([](RawRig& rig) { rig.right.fy = 1e308; }),
              HasSubstr("right.fy = 1e+308"));
  EXPECT_THAT(ErrorAfter([](RawRig& rig) { rig.tof.fy = 8; }), HasSubstr("tof.fy = 8"));
  EXPECT_THAT(ErrorAfter([](RawRig& rig) { rig.right.cx = 1e9; }),
              AllOf(HasSubstr("right.cx = 1e+09"), HasSubstr("-6400 to 6400 px")));
  EXPECT_THAT(ErrorAfter([](RawRig& rig) { rig.left.distortion[0] = 1e9; }),
              AllOf(HasSubstr("left.distortion"), HasSubstr("0 to 10 times")));
  EXPECT_THAT(ErrorAfter([](RawRig& rig) { rig.left_from_right.translation_m.x() = 1e308; }),
              AllOf(HasSubstr("translation_m = 1e+308"), HasSubstr("-1000 to 1000 m")));
  EXPECT_THAT(ErrorAfter([](RawRig& rig) { rig.left_from_right.translation_m << 1e-308, 0, 0; }),
              AllOf(HasSubstr("translation_m x = 1e-308"), HasSubstr("0.0001 m or more")));
}

// Of barrel distortion so strong that the image's corners would lie nearer to its middle than what
// is between.
TEST_F(RigFile, RefusesDistortionThatFoldsTheImage) {
  EXPECT_THAT(
      ErrorAfter([](RawRig& rig) {
        rig.left.distortion = {-0.9, 0, 0, 0, 0};
      }),
      AllOf(HasSubstr("left.distortion"), HasSubstr("folds the image"), HasSubstr("up to 6 px")));
  EXPECT_THAT(ErrorAfter([](RawRig& rig) {
                rig.tof.distortion = {0, 0, 0, 0, -9};
              }),
              AllOf(HasSubstr("tof.distortion"), HasSubstr("folds the image")));
}

TEST_F(RigFile, RefusesCamerasThatDoNotLookAtOneScene) {
  EXPECT_THAT(ErrorAfter([](RawRig& rig) {
                rig.left_from_right = TurnedBy(180, Eigen::Vector3d::UnitY());
              }),
              AllOf(HasSubstr("angle between the cameras = 180"), HasSubstr("0 to 60 degrees")));
  EXPECT_THAT(ErrorAfter([](RawRig& rig) { rig.left_from_right.translation_m << 0.001, 0, 1; }),
              AllOf(HasSubstr("normal to the baseline"), HasSubstr("0 to 60 degrees")));
  EXPECT_THAT(
      ErrorAfter([](RawRig& rig) { rig.left_from_right = TurnedBy(40, Eigen::Vector3d::UnitX()); }),
      AllOf(HasSubstr("vertical overlap of the rectified views"), HasSubstr("30 to 100 %")));
  EXPECT_THAT(
      ErrorAfter([](RawRig& rig) { rig.left_from_right = TurnedBy(55, Eigen::Vector3d::UnitY()); }),
      AllOf(HasSubstr("what rectification keeps"), HasSubstr("10 to 100 %")));
  EXPECT_THAT(ErrorAfter([](RawRig& rig) { rig.right.fx = rig.right.fy = 9000; }),
              AllOf(HasSubstr("what rectification keeps"), HasSubstr("10 to 100 %")));
}

// What people copy.
TEST_F(RigFile, IsAsTheReadmeOfCalibrateShowsOne) {
  std::ostringstream readme;
  readme << std::ifstream(std::string(SPROUT_SOURCE_DIR) + "/services/tools/calibrate/README.md")
                .rdbuf();
  const std::string text = readme.str();
  const std::string fence = "```textproto\n";
  const size_t begin = text.find(fence);
  ASSERT_NE(begin, std::string::npos);
  Write(text.substr(begin + fence.size(),
                    text.find("```\n", begin + fence.size()) - begin - fence.size()));
  EXPECT_EQ(Error(), "no error");
}

}  // namespace
}  // namespace sprout
