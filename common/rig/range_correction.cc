#include "common/rig/range_correction.h"

#include <algorithm>

namespace sprout {
namespace {

constexpr double kMaxRangeM = 1e4;
constexpr double kMaxOffsetM = 100;  // as range_offset_m

}  // namespace

CorrectionKnot CorrectionAt(std::span<const CorrectionKnot> correction, double range_m) {
  if (correction.empty()) return {.range_m = range_m};
  const auto above = std::ranges::upper_bound(correction, range_m, {}, &CorrectionKnot::range_m);
  CorrectionKnot at = above == correction.end() ? correction.back() : *above;
  at.range_m = range_m;
  if (above == correction.begin() || above == correction.end()) return at;
  const CorrectionKnot& below = *(above - 1);
  const double share = (range_m - below.range_m) / (above->range_m - below.range_m);
  at.offset_m = below.offset_m + share * (above->offset_m - below.offset_m);
  at.sigma_m = below.sigma_m + share * (above->sigma_m - below.sigma_m);
  return at;
}

double BrightnessOf(double amplitude, double middle) {
  return amplitude > 0 ? amplitude / (amplitude + middle) - 0.5 : 0;
}

void CheckCorrection(Checks& checks, const std::string& name,
                     std::span<const CorrectionKnot> correction) {
  checks.Require(correction.size() <= kMaxCorrectionKnots, (name + ": knots").c_str(),
                 correction.size(), "up to " + std::to_string(kMaxCorrectionKnots));
  for (size_t i = 0; i < correction.size(); ++i) {
    const CorrectionKnot& knot = correction[i];
    const std::string at = name + "[" + std::to_string(i) + "].";
    checks.Within(at + "range_m", knot.range_m, 0, kMaxRangeM, "m")
        .Within(at + "offset_m", knot.offset_m, -kMaxOffsetM, kMaxOffsetM, "m")
        .Within(at + "sigma_m", knot.sigma_m, 0, kMaxOffsetM, "m");
    if (i == 0) continue;
    const CorrectionKnot& below = correction[i - 1];
    checks
        .Require(knot.range_m > below.range_m, (at + "range_m").c_str(), knot.range_m,
                 "more than that of the knot before")
        .Require(knot.range_m + knot.offset_m > below.range_m + below.offset_m,
                 (at + "offset_m").c_str(), knot.offset_m,
                 "one that leaves farther points farther than those of the knot before");
  }
}

void CheckCorrection(Checks& checks, const std::string& name,
                     const AmplitudeCorrection& correction) {
  if (correction.empty()) return;
  checks.Within(name + ".offset_m", correction.offset_m, -kMaxOffsetM, kMaxOffsetM, "m")
      .Within(name + ".sigma_m", correction.sigma_m, 0, kMaxOffsetM, "m")
      .Positive((name + ".middle").c_str(), correction.middle);
}

}  // namespace sprout
