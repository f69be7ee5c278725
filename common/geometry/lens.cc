#include "common/geometry/lens.h"

#include <Eigen/Geometry>

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

}  // namespace sprout
