#include "common/scenes/lens_view.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/core/quantile.h"
#include "common/geometry/lens.h"

namespace sprout::scenes {
namespace {

Vec3 ToVec3(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

// @param reach  beyond the pixel's own borders, samples.
Footprint FootprintOf(const TofSamples& samples, int tof_u, int tof_v, int reach) {
  constexpr int kSide = TofSamples::kPerSide;
  const cv::Rect own(tof_u * kSide, tof_v * kSide, kSide, kSide);
  const cv::Rect area = (own - cv::Point(reach, reach) + cv::Size(2 * reach, 2 * reach)) &
                        cv::Rect({0, 0}, samples.depth_m.size());
  std::vector<double> depths;
  depths.reserve(static_cast<size_t>(area.area()));
  Footprint footprint{.samples = area.area()};
  double weighted = 0;
  double unweighted = 0;
  for (int y = area.y; y < area.y + area.height; ++y) {
    for (int x = area.x; x < area.x + area.width; ++x) {
      const double depth_m = samples.depth_m(y, x);
      if (!std::isfinite(depth_m)) continue;
      const double light = samples.albedo(y, x) / (depth_m * depth_m);
      footprint.light += light;
      weighted += light * depth_m;
      unweighted += depth_m;
      depths.push_back(depth_m);
    }
  }
  if (depths.empty()) return footprint;
  footprint.known = static_cast<int>(depths.size());
  footprint.mixed_m =
      footprint.light > 0 ? weighted / footprint.light : unweighted / footprint.known;
  footprint.light /= footprint.known;
  footprint.middle_m = Median(depths);
  const auto [nearest, farthest] = std::ranges::minmax(depths);
  footprint.spread = farthest / nearest - 1;
  return footprint;
}

}  // namespace

LensView::LensView(const Lens& lens, const Rotation& left_from_camera,
                   const Eigen::Vector3d& position_m, int rays_per_side)
    : size_(lens.size() * rays_per_side), origin_(ToVec3(position_m)) {
  const Eigen::Matrix3d rotation = left_from_camera.toRotationMatrix();
  const auto pixel_of = [&](int ray) { return (ray + 0.5) / rays_per_side - 0.5; };
  directions_.reserve(static_cast<size_t>(size_.area()));
  for (int y = 0; y < size_.height; ++y) {
    for (int x = 0; x < size_.width; ++x) {
      const Eigen::Vector2d direction = DirectionOfPixel(lens, {pixel_of(x), pixel_of(y)});
      directions_.push_back(ToVec3(rotation * direction.homogeneous()));
    }
  }
}

void LensView::Cast(const std::vector<Solid>& solids, double focal_px, const Visit& visit) const {
  const auto cast = [&](int x, int y) {
    // The direction has z = 1 in the camera's frame, so the parameter is the depth there.
    const size_t index = static_cast<size_t>(y) * static_cast<size_t>(size_.width);
    const Ray ray{origin_, directions_[index + static_cast<size_t>(x)]};
    double depth_m = std::numeric_limits<double>::infinity();
    const Solid* nearest = nullptr;
    for (const Solid& solid : solids) {
      const double candidate_m = Intersect(solid, ray);
      if (candidate_m >= depth_m) continue;
      depth_m = candidate_m;
      nearest = &solid;
    }
    if (nearest == nullptr) return;
    visit(x, y, depth_m, ColourAt(*nearest, ray.origin + depth_m * ray.direction, focal_px));
  };
  cv::parallel_for_({0, size_.height}, [&](const cv::Range& rows) {
    for (int y = rows.start; y < rows.end; ++y) {
      for (int x = 0; x < size_.width; ++x) cast(x, y);
    }
  });
}

TofSamples RenderTof(const LensView& view, const std::vector<Solid>& solids, double focal_px) {
  TofSamples samples(view.size() / TofSamples::kPerSide);
  view.Cast(solids, focal_px, [&](int x, int y, double depth_m, const Vec3& bgr) {
    samples.depth_m(y, x) = static_cast<float>(depth_m);
    samples.albedo(y, x) = static_cast<float>(Dot({0.114, 0.587, 0.299}, bgr) / 255);
  });
  return samples;
}

std::vector<Footprint> FootprintsOf(const TofSamples& samples, double footprint_px) {
  const auto reach = static_cast<int>(std::lround((footprint_px - 1) / 2 * TofSamples::kPerSide));
  const cv::Size size = samples.depth_m.size() / TofSamples::kPerSide;
  std::vector<Footprint> footprints;
  footprints.reserve(static_cast<size_t>(size.area()));
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) footprints.push_back(FootprintOf(samples, u, v, reach));
  }
  return footprints;
}

}  // namespace sprout::scenes
