#include "services/refine/stereo/unsure_points.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "services/refine/range/range_rules.h"

namespace sprout::refine {
namespace {

double SharedSigmaPx(const Seed& point, double noise_px) {
  return std::sqrt(std::max(0.0, double{point.sigma_px} * point.sigma_px - noise_px * noise_px));
}

}  // namespace

bool UnsurePoints::IsUnsure(const Seed& point, const RangeNoise& noise) {
  const double noise_px = noise.PxAt(point.disparity());
  return SharedSigmaPx(point, std::min(noise_px, RangeRules::kMaxNoisePx)) > RangeRules::kUnsurePx;
}

int UnsurePoints::Drop(const CellGrid& grid, const RangeNoise& noise, std::span<const Seed> stereo,
                       std::vector<Seed>& points) {
  others_.clear();
  std::ranges::copy_if(points, std::back_inserter(others_),
                       [&](const Seed& point) { return !IsUnsure(point, noise); });
  if (others_.size() == points.size()) return 0;
  others_.insert(others_.end(), stereo.begin(), stereo.end());
  surface_.Set(others_, grid);
  return static_cast<int>(std::erase_if(points, [&](const Seed& point) {
    const cv::Point cell = grid.CellOf(point.u, point.v);
    return IsUnsure(point, noise) && grid.Has(cell) &&
           surface_.SigmaPx(cell) < double{point.sigma_px};
  }));
}

}  // namespace sprout::refine
