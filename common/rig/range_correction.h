#pragma once

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

/// What ranges are corrected by that depends on how much light comes back.
struct AmplitudeCorrection {
  double offset_m = 0;  ///< from the darkest to the brightest; half of it is taken off the darkest
  double sigma_m = 0;   ///< standard deviation of offset_m
  double middle = 0;    ///< amplitude that is not corrected

  bool operator==(const AmplitudeCorrection&) const = default;
  bool empty() const { return *this == AmplitudeCorrection{}; }  ///< nothing is corrected
};

/// −1/2 for the darkest, 0 for the middle, 1/2 for the brightest: a / (a + middle) − 1/2. 0 for an
/// amplitude that is not known (not above 0).
double BrightnessOf(double amplitude, double middle);

/// Knots in the order of their ranges, ranges within 10 km, offsets within 100 m, standard
/// deviations of 0 or more, and the corrected range grows with the measured one.
/// @param name  of the field, for the error.
void CheckCorrection(Checks& checks, const std::string& name,
                     std::span<const CorrectionKnot> correction);
/// Empty, or an offset within 100 m, a standard deviation of 0 or more, a middle above 0.
void CheckCorrection(Checks& checks, const std::string& name,
                     const AmplitudeCorrection& correction);

}  // namespace sprout
