#include "services/refine/surface/range_steps.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "services/refine/surface/surface_rules.h"

namespace sprout::refine {

void AddStepSigma(const RectifiedPair& pair, const TofImage& tof,
                  std::span<ProjectedPoint> points) {
  const auto depth_of = [&](const ProjectedPoint& point) {
    return tof.depth_m(point.tof_v, point.tof_u);
  };
  std::vector<float> depths;
  const size_t next = points.size() / SurfaceRules::kStepSample + 1;
  for (size_t i = 0; i < points.size(); i += next) depths.push_back(depth_of(points[i]));
  const size_t sample = depths.size();
  std::ranges::sort(depths);
  depths.erase(std::unique(depths.begin(), depths.end()), depths.end());
  if (depths.size() < SurfaceRules::kMinSteps ||
      sample < SurfaceRules::kPointsOfStep * depths.size()) {
    return;
  }
  for (ProjectedPoint& point : points) {
    // The least of those around, since some values may have no point.
    const auto at = std::ranges::lower_bound(depths, depth_of(point)) - depths.begin();
    const auto last = std::min(at + 2, std::ssize(depths) - 1);
    double step_m = HUGE_VAL;
    for (auto i = static_cast<size_t>(std::max<std::ptrdiff_t>(at - 1, 1));
         i <= static_cast<size_t>(last); ++i) {
      step_m = std::min(step_m, double{depths[i]} - double{depths[i - 1]});
    }
    const double depth_m = pair.DepthFromDisparity(point.seed.disparity());
    const double step_px = step_m * pair.focal_px * pair.baseline_m / (depth_m * depth_m);
    if (!(step_px > SurfaceRules::kCoarseStepPx)) continue;
    const auto sigma_px = static_cast<float>(std::sqrt((step_px * step_px - 1) / 12));
    point.seed.sigma_px = std::hypot(point.seed.sigma_px, sigma_px);
  }
}

}  // namespace sprout::refine
