#include "services/refine/stereo/search_reach.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "common/core/disparity_image.h"
#include "services/refine/stereo/stereo_rules.h"

namespace sprout::refine {

int InfinityPx(const RectifiedPair& pair) {
  return static_cast<int>(std::ceil(std::clamp<double>(pair.cx - pair.cx_right, 0, pair.width)));
}

std::string BeyondSearch(const inputs::Findings& findings, const RefineConfig& config,
                         const RectifiedPair& pair, bool has_ranges) {
  using enum inputs::Question;
  constexpr double kRoom = 1.25;  // for the nearest of what is near
  const int most = config.stereo_max_disparity_px() > 0
                       ? config.stereo_max_disparity_px()
                       : pair.width / StereoRules::kWidthsPerDisparity + InfinityPx(pair);
  const auto sides = std::ranges::find(findings, kSides, &inputs::Finding::question);
  const bool is_known = sides != findings.end() && sides->verdict != inputs::Verdict::kBad;
  if (has_ranges && !AnyIsBad(findings, {kPlace, kScale, kMoment})) return "";
  if (!config.stereo_seeds() || !is_known || sides->near_px <= most) return "";
  return fmt::format(
      "a tenth of what both images show has disparities above {:.0f} px, and stereo is searched up "
      "to {} px: near things need refine {{ stereo_max_disparity_px: {:.0f} }}",
      sides->near_px, most, std::min<double>(kRoom * sides->near_px, DisparityImage::kMaxWholePx));
}

}  // namespace sprout::refine
