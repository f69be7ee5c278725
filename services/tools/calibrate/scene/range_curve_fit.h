#pragma once

#include <vector>

#include "common/rig/range_correction.h"

namespace sprout::calibrate {

/// How far the ToF camera is off at a match of the pair.
struct RangeSample {
  double range_m = 0;     ///< that the ToF camera measured, along the ray
  double error_m = 0;     ///< that less stereo's
  double sigma_m = 0;     ///< standard deviation of error_m, > 0
  double shared_m = 0;    ///< that of an error that all samples at this range share
  double yaw_m = 0;       ///< what a yaw of the pair by its standard deviation adds to error_m
  size_t part = 0;        ///< of the image: its samples share errors
  double brightness = 0;  ///< BrightnessOf() its amplitude
};

/// What has to be added to ranges.
struct RangeFit {
  RangeCorrection curve;     ///< of the range; without knots: nothing is significant
  double light_m = 0;        ///< a brightness of 1; 0: not significant
  double light_sigma_m = 0;  ///< its standard deviation
};

/// What a range sensor may be off by at a range, m: data sheets allow 1 to 2 cm.
inline constexpr double kExpectedRangeErrorM = 0.02;

/// Whether a correction is worth making: more than four standard deviations and 2 mm from 0.
bool IsSignificantCorrection(double offset_m, double sigma_m);

/// What has to be added to ranges: straight lines between knots that minimise
///
///     ¼ Σ ρ((c(r_i) + l h_i + e_i) / (s σ_i)) + Σ c_k² / τ² + l² / τ²
///
/// with h_i the brightness, a quarter since matches share errors, ρ Cauchy's loss, s ≥ 1 the
/// residuals' robust scatter, τ = 20 mm what is expected of a range sensor. Each knot has the same
/// number of samples, at least 40, and ranges 5 % apart; there are up to 24. Samples between knots
/// more than 25 % apart, and before the first or behind the last one, count only within 5 % of one.
/// By iterated least squares. The variance of a knot is the jackknife's over the samples' parts, at
/// least that of weighted least squares, and what samples share; a yaw adds its own, but what it
/// explains is not significant.
///
/// @returns l is 0 and the curve has no knots when neither is significant, as above. One thread;
///          same input, same bytes. O(samples).
RangeFit FitRangeCurve(std::vector<RangeSample> samples);

/// One correction after another: `first` of ranges as they are measured, `then` of what `first`
/// makes of them. At most kMaxCorrectionKnots knots.
RangeCorrection Chained(const RangeCorrection& first, const RangeCorrection& then);

}  // namespace sprout::calibrate
