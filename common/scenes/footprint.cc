#include "common/scenes/footprint.h"

#include <algorithm>
#include <cmath>

#include "common/core/quantile.h"

namespace sprout::scenes {
namespace {

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
