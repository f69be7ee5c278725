#include <gmock/gmock.h>

#include <vector>

#include "services/temporal/temporal_filter.h"
#include "tests/services/temporal/drive.h"

namespace sprout::temporal {
namespace {

// Of a drive whose poses another program gives, in a frame of its own; the images show nothing.
class GivenMotion : public testing::Test {
 protected:
  GivenMotion() {
    config_.set_motion(TemporalConfig::CHANNEL);
    for (size_t i = 0; i < drive_.size(); ++i) {
      drive_[i].left.setTo(130);
      CameraMotion& odometry = drive_[i].odometry.emplace();
      odometry.start_from_left = MovedBy(7, -3, 40, 0.5) * PoseAt(static_cast<int>(i));
      odometry.start_seq = 5;
    }
  }

  TemporalConfig config_ = Defaults();
  std::vector<TemporalInput> drive_ = Drive(8);
};

TEST_F(GivenMotion, MovesTheMap) {
  TemporalFilter given(config_), estimated(Defaults());
  TemporalOutput output, alone;
  for (const TemporalInput& input : drive_) {
    output = given.Compute(input);
    alone = estimated.Compute(input);
  }
  const MovingScene last = SceneFrom(PoseAt(7));
  EXPECT_EQ(alone.motion.reset, MemoryReset::kFewPoints);
  EXPECT_LT(ErrorOf(output.disparity, last), 0.75 * ErrorOf(drive_[7].disparity, last));
  const CameraMotion& motion = output.motion;
  EXPECT_EQ(motion.reset, MemoryReset::kNone);
  EXPECT_EQ(motion.resets, 0);
  EXPECT_EQ(motion.start_seq, 0);
  EXPECT_EQ(motion.last_seq, 6);
  EXPECT_EQ(motion.tracked, 0);
  const Pose way = PoseAt(0).Inverse() * PoseAt(7);
  EXPECT_LT((motion.start_from_left.translation_m - way.translation_m).norm(), 1e-9);
  EXPECT_LT((motion.start_from_left.Inverse() * way).rotation.vec().norm(), 1e-9);
}

// Finite poses whose difference is not, or leads beyond float.
TEST_F(GivenMotion, ForgetsWhereTheMotionCannotBe) {
  for (const double far_m : {1e308, 1e200, 1e45}) {
    std::vector<TemporalInput> drive = drive_;
    drive[2].odometry->start_from_left.translation_m.z() = far_m;
    drive[3].odometry->start_from_left.translation_m.z() = -far_m;
    TemporalFilter filter(config_);
    std::vector<MemoryReset> resets;
    for (const TemporalInput& input : drive) {
      const TemporalOutput output = filter.Compute(input);
      resets.push_back(output.motion.reset);
      EXPECT_TRUE(output.motion.start_from_left.translation_m.allFinite());
      EXPECT_TRUE(output.motion.last_from_left.translation_m.allFinite());
    }
    constexpr auto kBad = MemoryReset::kNoAgreement, kNone = MemoryReset::kNone;
    EXPECT_THAT(resets, testing::ElementsAre(MemoryReset::kFirst, kNone, kBad, kBad, kBad, kNone,
                                             kNone, kNone))
        << far_m;
  }
}

TEST_F(GivenMotion, OfImagesOfOneRowOrColumnGivesTheNewMap) {
  for (const cv::Size size : {cv::Size(64, 1), cv::Size(1, 48), cv::Size(1, 1)}) {
    TemporalFilter filter(config_);
    for (TemporalInput input : drive_) {
      const cv::Rect part(cv::Point(20, 20), size);
      input.left = input.left(part).clone();
      input.disparity = DisparityImage(input.disparity.counts()(part).clone());
      input.confidence = input.confidence(part).clone();
      input.pair.width = size.width;
      input.pair.height = size.height;
      const TemporalOutput output = filter.Compute(input);
      EXPECT_EQ(cv::norm(output.disparity.counts(), input.disparity.counts(), cv::NORM_INF), 0);
    }
  }
}

TEST_F(GivenMotion, ForgetsWhereThePosesHaveNothingInCommon) {
  drive_[3].odometry.reset();
  drive_[6].odometry->start_seq = 6;
  drive_[7].odometry->start_seq = 6;
  drive_[7].odometry->last_seq = 6;
  drive_[7].odometry->covariance[7] = 0.25;
  TemporalFilter filter(config_);
  std::vector<MemoryReset> resets;
  CameraMotion motion;
  for (const TemporalInput& input : drive_) {
    motion = filter.Compute(input).motion;
    resets.push_back(motion.reset);
  }
  constexpr auto kFew = MemoryReset::kFewPoints, kNone = MemoryReset::kNone;
  EXPECT_THAT(resets, testing::ElementsAre(MemoryReset::kFirst, kNone, kNone, kFew, kFew, kNone,
                                           kFew, kNone));
  EXPECT_EQ(motion.resets, 3);
  EXPECT_EQ(motion.start_seq, 6);
  EXPECT_EQ(motion.covariance[7], 0.25);
}

// Poses of no camera: whatever they say, no map has a disparity that cannot be.
TEST_F(GivenMotion, SurvivesAnyPose) {
  Pose far, turned, tiny;
  far.translation_m = {1e300, -1e300, 1e300};
  turned.rotation = Eigen::Quaterniond(0, 0, 1, 0);
  tiny.translation_m = {0, 0, 1e-320};
  for (const Pose& pose : {far, turned, tiny, MovedBy(0, 0, 3.999999), MovedBy(0, 0, -1e9)}) {
    TemporalFilter filter(config_);
    filter.Compute(drive_[0]);
    TemporalInput next = drive_[1];
    next.odometry->start_from_left = drive_[0].odometry->start_from_left * pose;
    const TemporalOutput output = filter.Compute(next);
    for (int v = 0; v < output.disparity.height(); ++v) {
      for (int u = 0; u < output.disparity.width(); ++u) {
        ASSERT_TRUE(!output.disparity.IsValid(u, v) ||
                    (output.disparity.Px(u, v) > -1 && output.disparity.Px(u, v) < 1024));
      }
    }
    filter.Compute(drive_[2]);
  }
}

}  // namespace
}  // namespace sprout::temporal
