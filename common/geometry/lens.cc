#include "common/geometry/lens.h"

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <vector>

namespace sprout {
namespace {

// Fixed-point steps of the inverse. A mild lens gains more than one digit with each.
constexpr int kInverseSteps = 20;

struct Distortion {
  double radial;               // factor
  Eigen::Vector2d tangential;  // offset
};

Distortion DistortionAt(const Lens& lens, const Eigen::Vector2d& p) {
  const auto [k1, k2, p1, p2, k3] = lens.distortion;
  const double r2 = p.x() * p.x() + p.y() * p.y();
  return {1 + r2 * (k1 + r2 * (k2 + r2 * k3)),
          {2 * p1 * p.x() * p.y() + p2 * (r2 + 2 * p.x() * p.x()),
           p1 * (r2 + 2 * p.y() * p.y()) + 2 * p2 * p.x() * p.y()}};
}

constexpr size_t kBrown = 5;

// Directions (x, y, 1) of pixels, by the model that the lens has.
std::vector<cv::Point2d> DirectionsOf(const Lens& lens, std::span<const double> distortion,
                                      bool is_fisheye, const std::vector<cv::Point2d>& pixels) {
  const cv::Matx33d k(lens.fx, 0, lens.cx, 0, lens.fy, lens.cy, 0, 0, 1);
  const std::vector<double> coefficients(distortion.begin(), distortion.end());
  std::vector<cv::Point2d> directions;
  if (is_fisheye) {
    cv::fisheye::undistortPoints(pixels, directions, k, coefficients);
  } else {
    const cv::TermCriteria exact(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 200, 1e-12);
    cv::undistortPoints(pixels, directions, k, coefficients, cv::noArray(), cv::noArray(), exact);
  }
  return directions;
}

// With x, y and r² of a direction, Brown's place is
//   x (1 + k1 r² + k2 r⁴ + k3 r⁶) + 2 p1 x y + p2 (r² + 2 x²), and y in the same way:
// linear in its coefficients.
void FitDistortion(const std::vector<cv::Point2d>& directions,
                   const std::vector<cv::Point2d>& pixels, Lens& lens) {
  Eigen::MatrixXd a(2 * std::ssize(directions), static_cast<Eigen::Index>(kBrown));
  Eigen::VectorXd b(a.rows());
  for (size_t i = 0; i < directions.size(); ++i) {
    const auto [x, y] = directions[i];
    const double r2 = x * x + y * y;
    const auto row = 2 * static_cast<Eigen::Index>(i);
    a.row(row) << x * r2, x * r2 * r2, 2 * x * y, r2 + 2 * x * x, x * r2 * r2 * r2;
    a.row(row + 1) << y * r2, y * r2 * r2, r2 + 2 * y * y, 2 * x * y, y * r2 * r2 * r2;
    b(row) = (pixels[i].x - lens.cx) / lens.fx - x;
    b(row + 1) = (pixels[i].y - lens.cy) / lens.fy - y;
  }
  const Eigen::VectorXd best = a.colPivHouseholderQr().solve(b);
  std::ranges::copy(best, lens.distortion.begin());
}

}  // namespace

Eigen::Vector2d PixelOfDirection(const Lens& lens, const Eigen::Vector2d& direction) {
  const Distortion distortion = DistortionAt(lens, direction);
  const Eigen::Vector2d distorted = distortion.radial * direction + distortion.tangential;
  return {lens.fx * distorted.x() + lens.cx, lens.fy * distorted.y() + lens.cy};
}

Eigen::Vector2d DirectionOfPixel(const Lens& lens, const Eigen::Vector2d& pixel) {
  const Eigen::Vector2d distorted{(pixel.x() - lens.cx) / lens.fx, (pixel.y() - lens.cy) / lens.fy};
  if (lens.distortion == decltype(lens.distortion){}) return distorted;  // as the steps give it
  Eigen::Vector2d direction = distorted;
  for (int step = 0; step < kInverseSteps; ++step) {
    const Distortion distortion = DistortionAt(lens, direction);
    direction = (distorted - distortion.tangential) / distortion.radial;
  }
  return direction;
}

cv::Mat1d RangePerDepth(const Lens& lens) {
  cv::Mat1d length(lens.size());
  for (int v = 0; v < length.rows; ++v) {
    for (int u = 0; u < length.cols; ++u) {
      length(v, u) = DirectionOfPixel(lens, {double(u), double(v)}).homogeneous().norm();
    }
  }
  return length;
}

LensFit FitBrown(const Lens& lens, std::span<const double> distortion, bool is_fisheye) {
  LensFit fit{.lens = lens};
  fit.lens.distortion = {};
  const size_t used = std::min(distortion.size(), kBrown);
  const bool is_brown = !is_fisheye && std::ranges::all_of(distortion.subspan(used),
                                                           [](double value) { return value == 0; });
  if (is_brown) {
    std::ranges::copy(distortion.first(used), fit.lens.distortion.begin());
    return fit;
  }
  constexpr int kSteps = 24;
  std::vector<cv::Point2d> pixels;
  for (int row = 0; row <= kSteps; ++row) {
    for (int column = 0; column <= kSteps; ++column) {
      pixels.emplace_back((lens.width - 1.0) * column / kSteps, (lens.height - 1.0) * row / kSteps);
    }
  }
  const std::vector<cv::Point2d> directions = DirectionsOf(lens, distortion, is_fisheye, pixels);
  FitDistortion(directions, pixels, fit.lens);
  for (size_t i = 0; i < pixels.size(); ++i) {
    const Eigen::Vector2d again = PixelOfDirection(fit.lens, {directions[i].x, directions[i].y});
    const double off_px = (again - Eigen::Vector2d(pixels[i].x, pixels[i].y)).norm();
    fit.worst_px = std::isfinite(off_px) ? std::max(fit.worst_px, off_px)
                                         : std::numeric_limits<double>::infinity();
  }
  return fit;
}

}  // namespace sprout
