#include "services/tools/calibrate/scene/tof_patches.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace sprout::calibrate {
namespace {

constexpr double kHalfWindow = 2.5;  // of the points' spacing: some 25 points
constexpr size_t kMinPoints = 12;    // of these, beside a border or between a scanner's beams
// Points farther from the plane than this share of the distance belong to another surface: five
// times the noise of an SR4000 at 2 m, and of a lidar at 10 m.
constexpr double kMaxOffPlane = 0.01;
// Steeper surfaces are seen at a glancing angle: cosine between ray and normal.
constexpr double kMinFacing = 0.3;
// Error that all points of a patch share, as share of the distance: a tenth of kMaxOffPlane.
constexpr double kSharedError = 0.001;
// A surface is bent, and no plane, when its middle is off the plane by more than kSharedError, and
// by so many standard deviations.
constexpr double kBendSigmas = 3;

// Whether points bend away from a plane through their mean to all sides, as on a ball: in its
// middle such a surface lies before the plane, and all matches there err alike.
bool IsBent(const std::vector<Eigen::Vector3d>& points, const Eigen::Vector3d& mean,
            const Eigen::Vector3d& normal) {
  // A line through distances from the plane, over squared distances from the middle along it.
  const auto n = static_cast<double>(points.size());
  double off_squares = 0;
  double round = 0;
  double round_squares = 0;
  double products = 0;
  for (const Eigen::Vector3d& point : points) {
    const double off_m = normal.dot(point - mean);
    const double round_m2 = (point - mean).squaredNorm() - off_m * off_m;
    off_squares += off_m * off_m;
    round += round_m2;
    round_squares += round_m2 * round_m2;
    products += round_m2 * off_m;
  }
  const double spread = round_squares - round * round / n;
  if (spread <= 0) return false;
  const double bend = products / spread;  // distances sum to 0
  const double scatter_m = std::sqrt(std::max(0.0, off_squares - bend * products) / (n - 4));
  const double middle_m = std::abs(bend) * round / n;
  const double sigma_m = scatter_m / std::sqrt(spread) * round / n;
  return middle_m > std::max(kSharedError * mean.norm(), kBendSigmas * sigma_m);
}

}  // namespace

TofPatches::TofPatches(const TofImage& tof, const TofProjector& projector) {
  const cv::Size size = projector.rig().pair.size();
  const cv::Rect2d image({0, 0}, cv::Size2d(size));
  std::vector<Point> inside;
  int behind = 0;
  for (const ProjectedPoint& point : projector.Project(tof, behind)) {
    const cv::Point2d left_px(point.seed.u, point.seed.v);
    if (!image.contains(left_px)) continue;
    inside.push_back(
        {left_px,
         double{tof.depth_m(point.tof_v, point.tof_u)} * projector.ray(point.tof_u, point.tof_v),
         tof.amplitude.empty() ? 0.0 : tof.amplitude(point.tof_v, point.tof_u)});
  }
  if (inside.empty()) return;
  spacing_px_ = std::max(1.0, std::sqrt(image.area() / static_cast<double>(inside.size())));
  cells_ = cv::Size(CellOf(image.br())) + cv::Size(1, 1);
  points_.resize(static_cast<size_t>(cells_.area()));
  for (const Point& point : inside) {
    const cv::Point cell = CellOf(point.left_px);
    points_[static_cast<size_t>(cell.y * cells_.width + cell.x)].push_back(point);
  }
}

std::optional<TofPatch> TofPatches::At(const cv::Point2d& left_px) const {
  const double reach_px = kHalfWindow * spacing_px_;
  const cv::Point first = CellOf(left_px - cv::Point2d(reach_px, reach_px));
  const cv::Point last = CellOf(left_px + cv::Point2d(reach_px, reach_px));
  std::vector<Eigen::Vector3d> around;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  double light = 0;
  for (int row = std::max(0, first.y); row <= std::min(cells_.height - 1, last.y); ++row) {
    for (int column = std::max(0, first.x); column <= std::min(cells_.width - 1, last.x);
         ++column) {
      for (const Point& point : points_[static_cast<size_t>(row * cells_.width + column)]) {
        const cv::Point2d off = point.left_px - left_px;
        if (std::max(std::abs(off.x), std::abs(off.y)) > reach_px) continue;
        around.push_back(point.in_tof);
        mean += point.in_tof;
        light += point.amplitude;
      }
    }
  }
  const size_t count = around.size();
  if (count < kMinPoints) return std::nullopt;
  mean /= static_cast<double>(count);
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (size_t i = 0; i < count; ++i) {
    scatter += (around[i] - mean) * (around[i] - mean).transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(scatter);
  TofPatch patch{.normal = solver.eigenvectors().col(0),
                 .amplitude = light / static_cast<double>(count)};
  const Eigen::Vector3d ray = mean.normalized();
  if (patch.normal.dot(ray) < 0) patch.normal = -patch.normal;
  patch.distance_m = patch.normal.dot(mean);
  patch.per_range = patch.normal.dot(ray);
  if (patch.per_range < kMinFacing) return std::nullopt;
  double sum = 0;
  for (const Eigen::Vector3d& point : around) {
    const double off_m = patch.normal.dot(point) - patch.distance_m;
    if (std::abs(off_m) > kMaxOffPlane * mean.norm()) return std::nullopt;
    sum += off_m * off_m;
  }
  if (IsBent(around, mean, patch.normal)) return std::nullopt;
  const auto n = static_cast<double>(count);
  patch.sigma_m = std::hypot(std::sqrt(sum / (n - 3) / n), kSharedError * mean.norm());
  return patch;
}

}  // namespace sprout::calibrate
