#include "services/capture/brown_lens.h"

namespace sprout {
namespace {

// Fixed-point steps of the inverse. A mild lens gains more than one digit with each.
constexpr int kInverseSteps = 20;

struct Distortion {
  double radial;               // factor
  Eigen::Vector2d tangential;  // offset
};

Distortion DistortionAt(const TofCamera& camera, const Eigen::Vector2d& p) {
  const auto [k1, k2, p1, p2, k3] = camera.distortion;
  const double r2 = p.x() * p.x() + p.y() * p.y();
  return {1 + r2 * (k1 + r2 * (k2 + r2 * k3)),
          {2 * p1 * p.x() * p.y() + p2 * (r2 + 2 * p.x() * p.x()),
           p1 * (r2 + 2 * p.y() * p.y()) + 2 * p2 * p.x() * p.y()}};
}

}  // namespace

Eigen::Vector2d PixelOfDirection(const TofCamera& camera, const Eigen::Vector2d& direction) {
  const Distortion distortion = DistortionAt(camera, direction);
  const Eigen::Vector2d distorted = distortion.radial * direction + distortion.tangential;
  return {camera.fx * distorted.x() + camera.cx, camera.fy * distorted.y() + camera.cy};
}

Eigen::Vector2d DirectionOfPixel(const TofCamera& camera, const Eigen::Vector2d& pixel) {
  const Eigen::Vector2d distorted{(pixel.x() - camera.cx) / camera.fx,
                                  (pixel.y() - camera.cy) / camera.fy};
  Eigen::Vector2d direction = distorted;
  for (int step = 0; step < kInverseSteps; ++step) {
    const Distortion distortion = DistortionAt(camera, direction);
    direction = (distorted - distortion.tangential) / distortion.radial;
  }
  return direction;
}

}  // namespace sprout
