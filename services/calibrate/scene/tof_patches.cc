#include "services/calibrate/scene/tof_patches.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

namespace sprout::calibrate {
namespace {

constexpr int kRadius = 2;   // of a patch, ToF pixels
constexpr int kFewest = 20;  // of its 25 pixels
// Points farther from the plane than this share of the distance belong to another surface: three
// times the noise of an SR4000 at 2 m.
constexpr double kMostOff = 0.006;
// Steeper surfaces are seen at a glancing angle: cosine between ray and normal.
constexpr double kLeastFacing = 0.3;
// What errs alike in all points of a patch, as share of the distance: a tenth of kMostOff.
constexpr double kSharedError = 0.0006;

}  // namespace

TofPatches::TofPatches(const TofImage& tof, const TofProjector& projector)
    : tof_(tof), projector_(projector) {
  const Rig& rig = projector.rig();
  int behind = 0;
  points_ = projector.Project(tof, behind);
  cell_px_ = std::max(1.0, rig.pair.focal_px / std::min(rig.tof.fx, rig.tof.fy));
  nearest_ = cv::Mat1i(static_cast<int>(rig.pair.height / cell_px_) + 1,
                       static_cast<int>(rig.pair.width / cell_px_) + 1, -1);
  const cv::Rect2d image({0, 0}, cv::Size2d(rig.pair.size()));
  for (size_t i = 0; i < points_.size(); ++i) {
    const Seed& seed = points_[i].seed;
    if (!image.contains(cv::Point2d(seed.u, seed.v))) continue;
    int& here =
        nearest_(static_cast<int>(seed.v / cell_px_), static_cast<int>(seed.u / cell_px_));
    if (here < 0 ||
        seed.disparity() > points_[static_cast<size_t>(here)].seed.disparity()) {
      here = static_cast<int>(i);
    }
  }
}

std::optional<TofPatch> TofPatches::At(const cv::Point2d& left_px) const {
  const ProjectedPoint* centre = nullptr;
  double best = 1.5 * cell_px_;
  const int row = static_cast<int>(left_px.y / cell_px_);
  const int column = static_cast<int>(left_px.x / cell_px_);
  for (int v = std::max(0, row - 1); v <= std::min(nearest_.rows - 1, row + 1); ++v) {
    for (int u = std::max(0, column - 1); u <= std::min(nearest_.cols - 1, column + 1); ++u) {
      if (nearest_(v, u) < 0) continue;
      const ProjectedPoint& point = points_[static_cast<size_t>(nearest_(v, u))];
      const double distance = std::hypot(point.seed.u - left_px.x, point.seed.v - left_px.y);
      if (distance < best) {
        best = distance;
        centre = &point;
      }
    }
  }
  if (centre == nullptr) return std::nullopt;

  std::array<Eigen::Vector3d, static_cast<size_t>((2 * kRadius + 1) * (2 * kRadius + 1))> around;
  size_t count = 0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (int v = centre->tof_v - kRadius; v <= centre->tof_v + kRadius; ++v) {
    for (int u = centre->tof_u - kRadius; u <= centre->tof_u + kRadius; ++u) {
      if (u < 0 || v < 0 || u >= tof_.depth_m.cols || v >= tof_.depth_m.rows) continue;
      const float depth_m = tof_.depth_m(v, u);
      if (!IsReturn(depth_m)) continue;
      around[count] = double{depth_m} * projector_.ray(u, v);
      mean += around[count++];
    }
  }
  if (count < kFewest) return std::nullopt;
  mean /= static_cast<double>(count);
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (size_t i = 0; i < count; ++i) {
    scatter += (around[i] - mean) * (around[i] - mean).transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(scatter);
  TofPatch patch{.normal = solver.eigenvectors().col(0)};
  const Eigen::Vector3d ray = mean.normalized();
  if (patch.normal.dot(ray) < 0) patch.normal = -patch.normal;
  patch.distance_m = patch.normal.dot(mean);
  patch.per_range = patch.normal.dot(ray);
  if (patch.per_range < kLeastFacing) return std::nullopt;
  double sum = 0;
  for (size_t i = 0; i < count; ++i) {
    const double off_m = patch.normal.dot(around[i]) - patch.distance_m;
    if (std::abs(off_m) > kMostOff * mean.norm()) return std::nullopt;
    sum += off_m * off_m;
  }
  const auto n = static_cast<double>(count);
  patch.sigma_m = std::hypot(std::sqrt(sum / (n - 3) / n), kSharedError * mean.norm());
  return patch;
}

}  // namespace sprout::calibrate
