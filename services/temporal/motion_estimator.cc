#include "services/temporal/motion_estimator.h"

#include <Eigen/Dense>
#include <cstdint>
#include <random>
#include <vector>

namespace sprout::temporal {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr int kSamples = 200;  // if half of the points are inliers, all samples fail once in 10¹¹
constexpr int kSampleSteps = 5;  // of Gauss-Newton; motions from frame to frame are small
constexpr int kRefineSteps = 4;
constexpr double kMinDepthM = 1e-3;  // smallest depth of a point that the camera can see
constexpr double kChallenge = 1.1;

// Knuth's MMIX generator: the same numbers on every machine.
using Draws =
    std::linear_congruential_engine<uint64_t, 6364136223846793005, 1442695040888963407, 0>;

// The motion of a rotation vector and a translation. To first order, half the rotation vector is
// the vector part of its quaternion.
Pose SmallMotion(const Vector6& step) {
  Pose motion;
  motion.rotation = Eigen::Quaterniond(1, step[0] / 2, step[1] / 2, step[2] / 2).normalized();
  motion.translation_m = step.tail<3>();
  return motion;
}

class Estimator {
 public:
  Estimator(std::span<const SeenPoint> points, const RectifiedPair& pair, const MotionRule& rule)
      : points_(points), pair_(pair), inlier_px2_(rule.inlier_px * rule.inlier_px) {
    inliers_.reserve(points.size());
  }

  // Squared reprojection error, px²; infinite behind the camera.
  double ErrorOf(const SeenPoint& point, const Eigen::Matrix3d& rotation,
                 const Eigen::Vector3d& translation_m) const {
    const Eigen::Vector3d now = rotation * point.before_m + translation_m;
    if (!(now.z() > kMinDepthM)) return HUGE_VAL;
    const double u = pair_.focal_px * now.x() / now.z() + pair_.cx - point.after_px.x();
    const double v = pair_.focal_px * now.y() / now.z() + pair_.cy - point.after_px.y();
    return u * u + v * v;
  }

  int CountInliers(const Pose& motion) const {
    const Eigen::Matrix3d rotation = motion.rotation.toRotationMatrix();
    int count = 0;
    for (const SeenPoint& point : points_) {
      count += ErrorOf(point, rotation, motion.translation_m) <= inlier_px2_ ? 1 : 0;
    }
    return count;
  }

  const std::vector<SeenPoint>& InliersOf(const Pose& motion) {
    const Eigen::Matrix3d rotation = motion.rotation.toRotationMatrix();
    inliers_.clear();
    for (const SeenPoint& point : points_) {
      if (ErrorOf(point, rotation, motion.translation_m) <= inlier_px2_) inliers_.push_back(point);
    }
    return inliers_;
  }

  // Minimises the squared reprojection errors by Gauss-Newton. False where they do not fix a
  // motion.
  bool Fit(std::span<const SeenPoint> points, int steps, Pose& motion) {
    for (int step = 0; step < steps; ++step) {
      Vector6 gradient = Vector6::Zero();
      information_ = Matrix6::Zero();
      squares_ = 0;
      const Eigen::Matrix3d rotation = motion.rotation.toRotationMatrix();
      for (const SeenPoint& point : points) {
        const Eigen::Vector3d now = rotation * point.before_m + motion.translation_m;
        if (!(now.z() > kMinDepthM)) return false;
        const double scale = pair_.focal_px / now.z();
        const double x = now.x() / now.z();
        const double y = now.y() / now.z();
        const double error[2] = {point.after_px.x() - (pair_.focal_px * x + pair_.cx),
                                 point.after_px.y() - (pair_.focal_px * y + pair_.cy)};
        // Derivatives of the projection for a small motion after this one: three of the rotation
        // vector, three of the translation.
        const double f = pair_.focal_px;
        const double slopes[2][6] = {{-f * x * y, f * (1 + x * x), -f * y, scale, 0, -scale * x},
                                     {-f * (1 + y * y), f * x * y, f * x, 0, scale, -scale * y}};
        for (int k = 0; k < 2; ++k) {
          squares_ += error[k] * error[k];
          for (int i = 0; i < 6; ++i) {
            gradient[i] += slopes[k][i] * error[k];
            for (int j = 0; j <= i; ++j) information_(i, j) += slopes[k][i] * slopes[k][j];
          }
        }
      }
      information_ = information_.selfadjointView<Eigen::Lower>();
      const Eigen::LLT<Matrix6> factor(information_);
      if (factor.info() != Eigen::Success) return false;
      const Vector6 change = factor.solve(gradient);
      // No camera turns by more than a radian from frame to frame.
      if (!(change.head<3>().squaredNorm() < 1) || !change.allFinite()) return false;
      motion = SmallMotion(change) * motion;
    }
    return true;
  }

  // Covariance of the newest fit: the inverse of the normal matrix times the mean squared error of
  // a coordinate.
  Matrix6 Covariance(size_t points) const {
    const double freedom = std::max(1.0, 2 * static_cast<double>(points) - 6);
    return information_.inverse() * (squares_ / freedom);
  }

 private:
  std::span<const SeenPoint> points_;
  const RectifiedPair& pair_;
  double inlier_px2_;
  std::vector<SeenPoint> inliers_;
  Matrix6 information_ = Matrix6::Zero();
  double squares_ = 0;
};

}  // namespace

MotionEstimate EstimateMotion(std::span<const SeenPoint> points, const RectifiedPair& pair,
                              const Pose& as_before, const MotionRule& rule) {
  MotionEstimate estimate{
      .left_from_last = {}, .covariance = Matrix6::Zero(), .reset = MemoryReset::kFewPoints};
  if (static_cast<int>(points.size()) < rule.min_inliers) return estimate;
  Estimator estimator(points, pair, rule);
  Pose best;  // the first candidate: standing still
  int most = estimator.CountInliers(best);
  const auto challenge = [&](const Pose& motion) {
    const int inliers = estimator.CountInliers(motion);
    if (inliers <= kChallenge * most) return;
    most = inliers;
    best = motion;
  };
  challenge(as_before);
  Draws draws;
  Pose drawn_best = best;
  int drawn_most = 0;
  for (int i = 0; i < kSamples; ++i) {
    SeenPoint sample[3];
    for (SeenPoint& point : sample) point = points[(draws() >> 33) % points.size()];
    Pose motion = as_before;
    if (!estimator.Fit(sample, kSampleSteps, motion)) continue;
    const int inliers = estimator.CountInliers(motion);
    if (inliers <= drawn_most) continue;
    drawn_most = inliers;
    drawn_best = motion;
  }
  challenge(drawn_best);

  estimate.reset = MemoryReset::kNoAgreement;
  for (int round = 0; round < 2; ++round) {
    const std::vector<SeenPoint>& inliers = estimator.InliersOf(best);
    if (static_cast<int>(inliers.size()) < rule.min_inliers) return estimate;
    if (!estimator.Fit(inliers, kRefineSteps, best)) return estimate;
    estimate.covariance = estimator.Covariance(inliers.size());
  }
  estimate.inliers = estimator.CountInliers(best);
  if (estimate.inliers < rule.min_inliers ||
      estimate.inliers < rule.min_inlier_share * static_cast<double>(points.size())) {
    return estimate;
  }
  estimate.left_from_last = best;
  estimate.reset = MemoryReset::kNone;
  return estimate;
}

}  // namespace sprout::temporal
