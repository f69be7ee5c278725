#include <gtest/gtest.h>

#include <random>

#include "services/temporal/motion_estimator.h"
#include "services/temporal/point_tracker.h"
#include "tests/common/core/centred.h"
#include "tests/services/temporal/moving_scene.h"

namespace sprout::temporal {
namespace {

const RectifiedPair kPair = CentredPair(640, 480, 500, 0.2);

// Points all over the image, from 1 to 9 m.
std::vector<SeenPoint> Points(int count, const Pose& left_from_last) {
  std::mt19937 random(1);
  const auto draw = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random()) * 0x1p-32;
  };
  std::vector<SeenPoint> points;
  for (int i = 0; i < count; ++i) {
    const double z = draw(1, 9);
    const Eigen::Vector3d before(draw(-0.6, 0.6) * z, draw(-0.45, 0.45) * z, z);
    const Eigen::Vector3d now = left_from_last.rotation * before + left_from_last.translation_m;
    points.push_back({before,
                      {kPair.focal_px * now.x() / now.z() + kPair.cx,
                       kPair.focal_px * now.y() / now.z() + kPair.cy}});
  }
  return points;
}

TEST(MotionEstimator, FindsAMotionBeyondManyOutliers) {
  const Pose motion = MovedBy(0.1, -0.05, -0.4, 0.03);
  std::vector<SeenPoint> points = Points(400, motion);
  for (size_t i = 0; i < 200; ++i)
    points[i].after_px += Eigen::Vector2d(9.0 + 0.3 * double(i % 50), -5);
  const MotionEstimate estimate = EstimateMotion(points, kPair, {}, {});
  EXPECT_EQ(estimate.reset, MemoryReset::kNone);
  EXPECT_GE(estimate.inliers, 200);
  EXPECT_LT((estimate.left_from_last.translation_m - motion.translation_m).norm(), 1e-6);
  EXPECT_LT((estimate.left_from_last.Inverse() * motion).rotation.vec().norm(), 1e-6);
}

TEST(MotionEstimator, StandsStillBehindAThingThatMoves) {
  std::vector<SeenPoint> points = Points(400, {});
  const std::vector<SeenPoint> moved = Points(400, MovedBy(0.2, 0, 0));
  std::copy_n(moved.begin(), 190, points.begin());
  const MotionEstimate estimate = EstimateMotion(points, kPair, {}, {});
  EXPECT_EQ(estimate.reset, MemoryReset::kNone);
  EXPECT_LT(estimate.left_from_last.translation_m.norm(), 1e-6);
}

TEST(MotionEstimator, SaysThatPointsAreFew) {
  EXPECT_EQ(EstimateMotion(Points(19, {}), kPair, {}, {}).reset, MemoryReset::kFewPoints);
  EXPECT_EQ(EstimateMotion({}, kPair, {}, {}).reset, MemoryReset::kFewPoints);
}

TEST(MotionEstimator, SaysThatPointsDoNotAgree) {
  std::vector<SeenPoint> points = Points(100, {});
  std::mt19937 random(2);
  for (SeenPoint& point : points) {
    point.after_px = {static_cast<double>(random() % 640), static_cast<double>(random() % 480)};
  }
  EXPECT_EQ(EstimateMotion(points, kPair, {}, {}).reset, MemoryReset::kNoAgreement);
}

// What would make systems of equations singular.
TEST(MotionEstimator, SurvivesPointsInOnePlace) {
  std::vector<SeenPoint> points = Points(100, {});
  for (SeenPoint& point : points) point = points[0];
  EXPECT_EQ(EstimateMotion(points, kPair, {}, {}).reset, MemoryReset::kNoAgreement);
}

// The true places are those of the wall, 4 m away, and the board.
TEST(PointTracker, FindsPointsToATenthOfAPixel) {
  const Pose motion = MovedBy(0.08, 0.03, 0.1, 0.01);
  const MovingScene before = SceneFrom({});
  const MovingScene after = SceneFrom(motion);
  const std::vector<TrackedPoint> points =
      TrackCorners(BuildPyramid(before.left), BuildPyramid(after.left));
  ASSERT_GT(points.size(), 300U);
  int close = 0;
  for (const TrackedPoint& point : points) {
    const cv::Point at(cvRound(point.before.x), cvRound(point.before.y));
    const double z = before.pair.DepthFromDisparity(static_cast<double>(before.truth(at)));
    const Eigen::Vector3d there((point.before.x - before.pair.cx) / before.pair.focal_px * z,
                                (point.before.y - before.pair.cy) / before.pair.focal_px * z, z);
    const Pose back = motion.Inverse();
    const Eigen::Vector3d now = back.rotation * there + back.translation_m;
    const double u = before.pair.focal_px * now.x() / now.z() + before.pair.cx;
    const double v = before.pair.focal_px * now.y() / now.z() + before.pair.cy;
    close += std::hypot(u - point.after.x, v - point.after.y) < 0.1 ? 1 : 0;
  }
  EXPECT_GT(close,
            static_cast<int>(points.size()) * 7 / 10);  // the others see the edge of the board
}

TEST(PointTracker, DoesNotMindBrightness) {
  const MovingScene before = SceneFrom({});
  const cv::Mat after = SceneFrom(MovedBy(0.05, 0, 0)).left * 0.8 + 30;
  EXPECT_GT(TrackCorners(BuildPyramid(before.left), BuildPyramid(after)).size(), 300U);
}

TEST(PointTracker, FindsNothingInWhatHasNoTexture) {
  EXPECT_TRUE(FindCorners(BuildPyramid(cv::Mat1b(240, 320, uint8_t{100}))).empty());
  EXPECT_TRUE(FindCorners(BuildPyramid(cv::Mat1b())).empty());
}

}  // namespace
}  // namespace sprout::temporal
