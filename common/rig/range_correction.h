#ifndef SPROUT_COMMON_RIG_RANGE_CORRECTION_H_
#define SPROUT_COMMON_RIG_RANGE_CORRECTION_H_

#include <span>
#include <string>
#include <vector>

#include "common/core/checks.h"

namespace sprout {

/// What a range sensor's ranges are corrected by at one range.
struct CorrectionKnot {
  double range_m = 0;   ///< along the ray, after scale and offset
  double offset_m = 0;  ///< to be added
  double sigma_m = 0;   ///< standard deviation of offset_m

  bool operator==(const CorrectionKnot&) const = default;
};

/// A curve of range: straight lines between the knots, constant before the first and behind the
/// last. No knots: 0.
using RangeCorrection = std::vector<CorrectionKnot>;

/// Most knots of a curve.
inline constexpr size_t kMaxCorrectionKnots = 64;

/// The curve at a range.
CorrectionKnot CorrectionAt(std::span<const CorrectionKnot> correction, double range_m);

/// Knots in the order of their ranges, ranges within 10 km, offsets within 100 m, standard
/// deviations of 0 or more, and the corrected range grows with the measured one.
/// @param name  of the field, for the error.
void CheckCorrection(Checks& checks, const std::string& name,
                     std::span<const CorrectionKnot> correction);

}  // namespace sprout

#endif  // SPROUT_COMMON_RIG_RANGE_CORRECTION_H_
