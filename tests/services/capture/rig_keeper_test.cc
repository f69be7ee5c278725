#include "services/capture/rig_keeper.h"

#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <numbers>

#include "common/config/config_error.h"
#include "tests/common/picture/temporary_directory.h"
#include "tests/common/rig/tilted_rig.h"

namespace sprout::capture {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr double kDegree = std::numbers::pi / 180;

class RigKeeperTest : public ::testing::Test {
 protected:
  RigKeeperTest() {
    file_.mutable_left()->set_serial("4711");
    *file_.mutable_calibration() = ToCalibration(TiltedRig());
    config_.set_folder(folder_ / "rigs");
    config_.set_pause_s(60);
  }

  void Start() {
    current_ = std::make_shared<CurrentRig>(file_, "rig.textproto");
    first_ = current_->Get();
    keeper_.emplace(config_, current_);
  }

  // A change of the calibration in use, with verdict kWrong.
  RigChange Wrong(const Eigen::Vector3d& right, const Eigen::Vector3d& tof = {0, 0, 0},
                  double range_m = 0) const {
    RigChange change{.newest_frame = {.utime = 1, .seq = 2, .rig_id = current_->Get()->rig_id},
                     .verdict = RigChange::Verdict::kWrong,
                     .frames = 3};
    change.right.turn = right;
    change.tof.turn = tof;
    change.range_offset_m = range_m;
    return change;
  }

  RigKeeper::Outcome Consider(const RigChange& change, int second = 0) {
    return keeper_->Consider(change,
                             RigKeeper::Clock::time_point(std::chrono::seconds(1000 + second)));
  }

  std::string FileOf(const RigInUsePtr& rig) const {
    return folder_ / ("rigs/rig_" + rig->rig_id + ".textproto").c_str();
  }

  const TemporaryDirectory folder_;
  RigDescription file_;
  SelfCalibrateConfig config_;
  std::shared_ptr<CurrentRig> current_;
  RigInUsePtr first_;
  std::optional<RigKeeper> keeper_;
};

// Turn of a camera against where it was, in the axes of the left rectified frame.
Eigen::Vector3d TurnIn(const Eigen::Matrix3d& rectified_from_left, const Pose& now,
                       const Pose& before) {
  const Eigen::AngleAxisd turn(Eigen::Quaterniond(
      rectified_from_left * now.rotation.toRotationMatrix() *
      before.rotation.toRotationMatrix().transpose() * rectified_from_left.transpose()));
  return turn.angle() * turn.axis();
}

TEST_F(RigKeeperTest, TurnsTheCamerasAsTheRectifiedImagesShowIt) {
  Start();
  const Eigen::Vector3d right(0.004, -0.006, 0.003);
  const Eigen::Vector3d tof(-0.01, 0.02, 0.005);
  const RigKeeper::Outcome outcome = Consider(Wrong(right, tof, 0.012));

  EXPECT_TRUE(outcome.used) << outcome.text;
  const RigInUsePtr now = current_->Get();
  const RawRig before = TiltedRig();
  const RawRig& after = now->rectifier.raw();
  const Eigen::Matrix3d rectified_from_left = BackOf(RectificationOf(before).left_turn).transpose();
  EXPECT_LT(
      (TurnIn(rectified_from_left, after.left_from_right, before.left_from_right) - right).norm(),
      1e-9);
  EXPECT_LT((TurnIn(rectified_from_left, after.left_from_tof, before.left_from_tof) - tof).norm(),
            1e-9);
  EXPECT_NEAR(after.range_offset_m, before.range_offset_m + 0.012, 1e-12);
  // The places and the lenses stay.
  EXPECT_EQ(after.left_from_right.translation_m, before.left_from_right.translation_m);
  EXPECT_EQ(after.left_from_tof.translation_m, before.left_from_tof.translation_m);
  EXPECT_EQ(after.right.fx, before.right.fx);
  EXPECT_EQ(after.range_scale, before.range_scale);
  EXPECT_NE(now->rig_id, first_->rig_id);
  EXPECT_THAT(outcome.text, HasSubstr(now->rig_id + " instead of " + first_->rig_id));
  EXPECT_THAT(outcome.text,
              HasSubstr("put right by right camera pitch +0.229°, yaw -0.344°, roll +0.172°; ToF "
                        "camera pitch -0.573°, yaw +1.146°, roll +0.286°; ranges +12.0 mm: "));
}

TEST_F(RigKeeperTest, KeepsARigFileOfEveryCalibration) {
  Start();
  ASSERT_TRUE(Consider(Wrong({0.004, 0, 0})).used);
  const RigInUsePtr now = current_->Get();

  const RigDescription old = LoadRigFile(FileOf(first_));
  EXPECT_EQ(RigId(Rectifier(*CalibrationOf(old)).rig()), first_->rig_id);
  EXPECT_FALSE(old.has_board_calibration());
  const RigDescription changed = LoadRigFile(FileOf(now));
  EXPECT_EQ(changed.left().serial(), "4711");
  EXPECT_EQ(RigId(Rectifier(*CalibrationOf(changed)).rig()), RigId(now->rectifier.rig()));
  EXPECT_EQ(ConfigText(changed.board_calibration()), ConfigText(file_.calibration()));
}

TEST_F(RigKeeperTest, GivesAChangeOfTheRangesAloneANewName) {
  Start();
  ASSERT_TRUE(Consider(Wrong({0, 0, 0}, {0, 0, 0}, 0.02)).used);
  EXPECT_EQ(RigId(current_->Get()->rectifier.rig()), RigId(first_->rectifier.rig()));
  EXPECT_NE(current_->Get()->rig_id, first_->rig_id);
}

TEST_F(RigKeeperTest, UsesNothingThatIsNotWrongOrOfAnotherCalibration) {
  Start();
  RigChange change = Wrong({0.004, 0, 0});
  change.newest_frame.rig_id = "another";
  EXPECT_FALSE(Consider(change).used);
  change = Wrong({0.004, 0, 0});
  for (const auto verdict : {RigChange::Verdict::kRight, RigChange::Verdict::kUnseen}) {
    change.verdict = verdict;
    EXPECT_FALSE(Consider(change).used);
  }
  EXPECT_EQ(current_->Get(), first_);
}

TEST_F(RigKeeperTest, WaitsForNothingAfterAChangeThatIsNone) {
  Start();
  const RigKeeper::Outcome outcome = Consider(Wrong({0, 0, 0}));
  EXPECT_FALSE(outcome.used);
  EXPECT_THAT(outcome.text, HasSubstr("the change is 0"));
  EXPECT_EQ(current_->Get(), first_);
  EXPECT_TRUE(Consider(Wrong({0.004, 0, 0}), 1).used);
}

TEST_F(RigKeeperTest, ChangesAtMostOnceInAPause) {
  Start();
  EXPECT_TRUE(Consider(Wrong({0.001, 0, 0}), 0).used);
  const RigInUsePtr second = current_->Get();
  const RigKeeper::Outcome soon = Consider(Wrong({0.001, 0, 0}), 59);
  EXPECT_FALSE(soon.used);
  EXPECT_EQ(soon.text, "");
  EXPECT_EQ(current_->Get(), second);
  EXPECT_TRUE(Consider(Wrong({0.001, 0, 0}), 60).used);
}

TEST_F(RigKeeperTest, NeverGoesBeyondTheLimitsFromTheBoardsCalibration) {
  file_.mutable_self_calibration()->set_turn_deg(0.5);
  file_.mutable_self_calibration()->set_tof_turn_deg(0.8);
  file_.mutable_self_calibration()->set_range_mm(15);
  Start();
  ASSERT_TRUE(Consider(Wrong({0.4 * kDegree, 0, 0}, {0, 0.7 * kDegree, 0}, 0.01), 0).used);
  const RigInUsePtr second = current_->Get();

  // Each of them alone would be allowed.
  const auto refused = [&](const RigChange& change) {
    const RigKeeper::Outcome outcome = Consider(change, 100);
    EXPECT_FALSE(outcome.used);
    return outcome.text;
  };
  EXPECT_THAT(refused(Wrong({0.2 * kDegree, 0, 0})),
              HasSubstr("turn of the right camera = 0.6: allowed is 0 to 0.5 degrees"));
  EXPECT_THAT(refused(Wrong({0, 0, 0}, {0, 0.2 * kDegree, 0})),
              AllOf(HasSubstr("turn of the ToF camera = 0."), HasSubstr("0 to 0.8 degrees")));
  EXPECT_THAT(refused(Wrong({0, 0, 0}, {0, 0, 0}, 0.01)), HasSubstr("change of the ranges = 20"));
  EXPECT_THAT(refused(Wrong({0, 0, 0}, {0, 0, 0}, 0.01)), HasSubstr("calibrate with the board"));
  EXPECT_EQ(current_->Get(), second);
  EXPECT_TRUE(Consider(Wrong({-0.2 * kDegree, 0, 0}), 100).used);
}

TEST_F(RigKeeperTest, CountsFromTheBoardsCalibrationAlsoAfterARestart) {
  Start();
  ASSERT_TRUE(Consider(Wrong({0.8 * kDegree, 0, 0})).used);
  file_ = LoadRigFile(FileOf(current_->Get()));
  Start();
  EXPECT_FALSE(Consider(Wrong({0.4 * kDegree, 0, 0})).used);
}

TEST_F(RigKeeperTest, NeedsAFolderThatCanBeWritten) {
  config_.set_folder("");
  EXPECT_THROW(Start(), ConfigError);
  config_.set_folder("/proc/rigs");
  EXPECT_THROW(Start(), ConfigError);
}

}  // namespace
}  // namespace sprout::capture
