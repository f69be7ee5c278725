#include "services/refine/range/range_text.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <vector>

namespace sprout::refine {
namespace {

constexpr double kMinShare = 0.005;  // that is more than 0 %

// How many standard deviations of its own a knot is off.
double SigmasOf(const RangeKnot& knot) { return std::abs(knot.error_m) / knot.sigma_m; }

// Nearest, most and farthest of the knots whose error the images show; in a curve that is sure only
// as a whole, the surest of those that are off.
std::vector<RangeKnot> ShownKnots(const std::vector<RangeKnot>& curve) {
  constexpr double kStandardDeviations = 3;
  std::vector<RangeKnot> sure;
  std::ranges::copy_if(curve, std::back_inserter(sure),
                       [](const RangeKnot& knot) { return SigmasOf(knot) > kStandardDeviations; });
  if (sure.empty()) return {*std::ranges::max_element(curve, {}, SigmasOf)};
  const auto most = std::ranges::max_element(
      sure, {}, [](const RangeKnot& knot) { return std::abs(knot.error_m); });
  std::vector<RangeKnot> shown = {sure.front()};
  if (most != sure.begin()) shown.push_back(*most);
  if (most + 1 < sure.end()) shown.push_back(sure.back());
  return shown;
}

}  // namespace

std::optional<std::string> RangeErrorText(const RangeError& error) {
  if (error.curve.empty() || error.Refuses()) return std::nullopt;
  const std::string moved = fmt::format("{:.0f} % of its points were moved by more than {} px",
                                        100 * error.far_moved_share, RangeRules::kFarMovePx);
  if (error.curve_is_zero) {
    if (error.far_moved_share < kMinShare) return "";
    return "the range sensor is off as by multi-path: " + moved;
  }
  const std::vector<RangeKnot> shown = ShownKnots(error.curve);
  if (SigmasOf(shown.front()) < 1) return "the range sensor is off, at no depth for sure: " + moved;
  std::string knots;
  for (const RangeKnot& knot : shown) {
    knots += fmt::format("{}{:+.1f} ± {:.1f} mm at {:.2f} m", knots.empty() ? "" : ", ",
                         1000 * knot.error_m, 1000 * knot.sigma_m, knot.depth_m);
  }
  return fmt::format(
      "depths of the range sensor are off by {}; {}. If that stays so: sprout-calibrate refine",
      knots, moved);
}

}  // namespace sprout::refine
