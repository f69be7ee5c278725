
#include <gmock/gmock.h>

#include <numbers>

#include "common/bus/channels.h"
#include "common/messages/codec.h"
#include "common/rig/rectifier.h"
#include "common/rig/rig_file.h"
#include "services/tools/calibrate/program.h"
#include "services/tools/calibrate/scene/rig_change.h"
#include "tests/common/app/run_main.h"
#include "tests/common/logfile/sample_log.h"
#include "tests/services/tools/calibrate/knocked_scene.h"

namespace sprout::calibrate {
namespace {

using ::testing::HasSubstr;

class CalibrateRefine : public testing::Test {
 protected:
  CalibrateRefine() : rig_(TrueRig({640, 480})) {
    RigNumbers errors{};
    errors[kRoll] = 0.2 * std::numbers::pi / 180;
    errors[kPitch] = -0.15 * std::numbers::pi / 180;
    knocked_ = Changed(rig_, errors);
    WriteRig("rig.textproto", knocked_);
    images_ = RenderScene(rig_, 3, 0, true);
  }

  std::string File(const char* name) const { return folder_ / name; }

  void WriteRig(const char* name, const RawRig& rig) const {
    RigDescription description;
    description.mutable_left()->set_serial("4711");
    *description.mutable_calibration() = ToCalibration(rig);
    ASSERT_TRUE(SaveRigFile(File(name), description));
  }

  // A log with one frame; with a rig: rectified.
  std::string WriteLog(const RigImages& images, const std::optional<Rig>& rig) const {
    std::vector<Event> events;
    const FrameId id{.utime = 1'700'000'000'000'000, .seq = 0, .rig_id = rig ? RigId(*rig) : ""};
    const auto add = [&](Part part, const PartValue& value) {
      events.push_back(
          {.utime = id.utime,
           .channel = std::string(rig ? "" : kRawPrefix) + std::string(ChannelOf(part)),
           .data = EncodePart(id, part, value)});
    };
    if (rig) add(Part::kRig, *rig);
    add(Part::kLeft, images.left);
    add(Part::kRight, images.right);
    add(Part::kTof, images.tof);
    WriteBytes(folder_ / "run.lcm", MakeLog(events));
    return File("run.lcm");
  }

  MainOutcome Refine(std::vector<std::string> words) const {
    words.insert(words.begin(), {"sprout-calibrate", "refine"});
    words.insert(words.end(), {"--out", File("new.textproto")});
    return RunMain(words, CalibrateMain);
  }

  RigNumbers Left(const RawRig& truth) const {
    return ErrorsLeft(truth, RequireCalibration(LoadRigFile(File("new.textproto")), "new"));
  }

  const TemporaryDirectory folder_;
  RawRig rig_;
  RawRig knocked_;
  RigImages images_;
};

constexpr double kLimit = 0.02 * std::numbers::pi / 180;

TEST_F(CalibrateRefine, PutsARigRightFromUnrectifiedImagesAndKeepsItsDevices) {
  const MainOutcome outcome = Refine(
      {WriteLog(images_, {}), "--rig", File("rig.textproto"), "--report", File("report.html")});

  EXPECT_EQ(outcome.exit_code, 0) << outcome.out << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("calibration: good\n"));
  const RigNumbers left = Left(rig_);
  EXPECT_LT(std::abs(left[kRoll]), kLimit);
  EXPECT_LT(std::abs(left[kPitch]), kLimit);
  const RigDescription refined = LoadRigFile(File("new.textproto"));
  EXPECT_EQ(refined.left().serial(), "4711");
  EXPECT_EQ(ConfigText(refined.board_calibration()), ConfigText(ToCalibration(knocked_)));
  const std::string page = FileText(File("report.html"));
  EXPECT_THAT(page, HasSubstr("refined without a board: <span class=\"good\">good</span>"));
  EXPECT_THAT(page, HasSubstr("ToF points on the left image"));
}

TEST_F(CalibrateRefine, FindsTheSameFromRectifiedImages) {
  const Rectifier rectifier(knocked_);
  const auto images = RectifyImages(rectifier, images_).value();
  const std::string log = WriteLog(images, rectifier.rig());

  const MainOutcome outcome = Refine({log, "--rig", File("rig.textproto")});

  EXPECT_EQ(outcome.exit_code, 0) << outcome.out << outcome.err;
  const RigNumbers left = Left(rig_);
  EXPECT_LT(std::abs(left[kRoll]), kLimit);
  EXPECT_LT(std::abs(left[kPitch]), kLimit);

  // The images were not rectified with this one.
  WriteRig("rig.textproto", rig_);
  const MainOutcome other = Refine({log, "--rig", File("rig.textproto")});
  EXPECT_EQ(other.exit_code, 2);
  EXPECT_THAT(other.err, HasSubstr("was rectified with calibration " + RigId(rectifier.rig())));
}

TEST_F(CalibrateRefine, TakesTheCalibrationInALogWithoutARigFile) {
  const Rectifier rectifier(rig_);
  const auto images = RectifyImages(rectifier, images_).value();

  const MainOutcome outcome = Refine({WriteLog(images, rectifier.rig())});

  EXPECT_EQ(outcome.exit_code, 0) << outcome.out << outcome.err;
  for (const double error : Left(RawRigOf(rectifier.rig()))) EXPECT_LT(std::abs(error), 0.003);
}

TEST_F(CalibrateRefine, NeedsARigFileForUnrectifiedImages) {
  const MainOutcome outcome = Refine({WriteLog(images_, {})});

  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("its images are not rectified: --rig is needed"));
}

// The recording was replaced by the rig file.
TEST_F(CalibrateRefine, ReplacesNoRecording) {
  const std::string log = WriteLog(images_, std::nullopt);
  const auto bytes = std::filesystem::file_size(log);
  const std::string rig = File("rig.textproto");
  const MainOutcome over_log =
      RunMain({"sprout-calibrate", "refine", log, "--rig", rig, "--out", log}, CalibrateMain);
  EXPECT_EQ(over_log.exit_code, 2);
  EXPECT_THAT(over_log.err, HasSubstr("--out " + log + ": cannot be written (it is an input"));
  EXPECT_EQ(std::filesystem::file_size(log), bytes);
  const MainOutcome over_rig = Refine({log, "--rig", rig, "--report", rig});
  EXPECT_EQ(over_rig.exit_code, 2);  // before the work
  EXPECT_THAT(over_rig.err, HasSubstr("--report " + rig + ": cannot be written (it is an input"));
}

TEST_F(CalibrateRefine, SaysWhyASceneIsRefused) {
  images_.right = cv::Mat1b::zeros(images_.right.size());
  const MainOutcome outcome = Refine({WriteLog(images_, {}), "--rig", File("rig.textproto")});

  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("too little to see: 0 matches of 0 features in 1 frames"));
  EXPECT_FALSE(std::filesystem::exists(File("new.textproto")));
}

}  // namespace
}  // namespace sprout::calibrate
