#include "services/depth/scan.h"

#include <Eigen/Core>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

#include "services/depth/rays.h"

namespace sprout::depth {
namespace {

using Direction = Eigen::Vector2d;  // horizontal: x forward, y left

double Cross(const Direction& a, const Direction& b) { return a.x() * b.y() - a.y() * b.x(); }

// (cos, sin) of an angle of at most 10°, by their series: libm's differ between CPUs.
Direction UnitVector(double angle_rad) {
  Direction sums(1, 0);
  double term = 1;
  for (int power = 1; power < 20; ++power) {  // the last term is below 1e-30
    term *= angle_rad / power;
    if (power % 2 == 0) term = -term;
    sums[power % 2] += term;
  }
  return sums;
}

Direction Turned(const Direction& direction, const Direction& by) {
  return {direction.x() * by.x() - direction.y() * by.y(),
          direction.x() * by.y() + direction.y() * by.x()};
}

// The directions between two angles less than half a turn apart, and which of them a point has.
class Beams {
 public:
  /// @param right, left  outermost directions that have to be within.
  Beams(const Direction& right, const Direction& left, double step_rad) {
    const Direction step = UnitVector(step_rad);
    const Direction back(step.x(), -step.y());
    // Beam 0 is forward, and lies between the borders half a step to its right and left.
    const Direction half = UnitVector(step_rad / 2);
    Direction border(half.x(), -half.y());
    while (!IsBetween(border, Turned(border, step), right)) {
      // The shorter way round.
      const bool to_left = Cross({1, 0}, right) > 0;
      border = Turned(border, to_left ? step : back);
      first_ += to_left ? 1 : -1;
    }
    borders_ = {border, Turned(border, step)};
    while (!IsBetween(borders_[borders_.size() - 2], borders_.back(), left)) {
      borders_.push_back(Turned(borders_.back(), step));
    }
  }

  int first() const { return first_; }
  size_t count() const { return borders_.size() - 1; }

  /// @param guess  a beam nearby: neighbours in the image are neighbours here.
  size_t IndexOf(const Direction& point, size_t guess) const {
    while (guess > 0 && Cross(borders_[guess], point) < 0) --guess;
    while (guess + 1 < count() && Cross(borders_[guess + 1], point) >= 0) ++guess;
    return guess;
  }

 private:
  static bool IsBetween(const Direction& right, const Direction& left, const Direction& direction) {
    return Cross(right, direction) >= 0 && Cross(direction, left) > 0 && right.dot(direction) > 0;
  }

  int first_ = 0;
  std::vector<Direction> borders_;  // from right to left
};

struct Outermost {
  Direction right, left;
};

// The outermost directions that the image sees; nothing when it sees what is straight above or
// below.
std::optional<Outermost> OutermostOf(const Rays& rays, const RectifiedPair& pair) {
  std::array<Direction, 4> corners;
  for (size_t i = 0; i < corners.size(); ++i) {
    const double u = i % 2 == 0 ? 0 : pair.width - 1;
    const double v = i < 2 ? 0 : pair.height - 1;
    corners[i] = rays.Direction(u, v).head<2>();
  }
  const auto is_right_of_all = [&](const Direction& candidate, double sign) {
    for (const Direction& other : corners) {
      if (&other == &candidate) continue;
      const double cross = sign * Cross(candidate, other);
      if (cross < 0 || (cross == 0 && candidate.dot(other) <= 0)) return false;
    }
    return true;
  };
  std::optional<Direction> right, left;
  for (const Direction& corner : corners) {
    if (is_right_of_all(corner, 1)) right = corner;
    if (is_right_of_all(corner, -1)) left = corner;
  }
  if (!right || !left) return std::nullopt;
  return Outermost{*right, *left};
}

}  // namespace

Pose LevelFromLeft() {
  // x = z of the camera, y = −x, z = −y.
  return {.rotation = {0.5, -0.5, 0.5, -0.5}, .translation_m = Eigen::Vector3d::Zero()};
}

Result<PlanarScan> ScanOf(const DisparityImage& map, const RectifiedPair& pair,
                          const Pose& base_from_left, const ScanBand& band) {
  assert(map.size() == pair.size() && band.step_deg > 0 && band.step_deg <= 10);
  const Rays rays(pair, base_from_left);
  const std::optional<Outermost> ends = OutermostOf(rays, pair);
  if (!ends) {
    return Fail(
        "the image shows what is straight above or below the camera: no SCAN; allowed are "
        "cameras that look to the side");
  }
  const double step_rad = band.step_deg * std::numbers::pi / 180;
  const Beams beams(ends->right, ends->left, step_rad);
  const DepthOfCounts depth_m(pair);
  std::vector<double> nearest(beams.count(), std::numeric_limits<double>::infinity());
  size_t beam = 0;
  for (int v = 0; v < map.height(); ++v) {
    const Eigen::Vector3d start = rays.RowStart(v);
    for (int u = 0; u < map.width(); ++u) {
      const double z = double{depth_m(map.counts()(v, u))};
      if (z == 0) continue;
      const Eigen::Vector3d from_camera = z * (start + u * rays.per_u);
      const double height = rays.origin.z() + from_camera.z();
      if (height < band.min_height_m || height > band.max_height_m) continue;
      const Direction across = from_camera.head<2>();
      beam = beams.IndexOf(across, beam);
      nearest[beam] = std::min(nearest[beam], across.squaredNorm());
    }
  }
  PlanarScan scan{.ranges_m = {}, .first = beams.first(), .step_rad = step_rad};
  for (const double squared : nearest) {
    scan.ranges_m.push_back(static_cast<float>(std::sqrt(squared)));
  }
  return scan;
}

}  // namespace sprout::depth
