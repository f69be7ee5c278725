#pragma once

#include <numbers>
#include <optional>
#include <vector>

#include "services/tools/calibrate/scene/scene_adjustment.h"

namespace sprout::calibrate {

/// What matches share where all lie at one place between pixels, px. Measured with simulated rigs,
/// whose curves of ranges are off by 9 mm at 6.3 m.
inline constexpr double kSharedMatchPx = 0.015;

/// What ranges are off by, m: a sine of the 10 mm that data sheets allow.
inline constexpr double kRangeErrorM = 0.01 / std::numbers::sqrt2;

/// The number of the part of the left image, below 48, that errs by itself.
/// @param left  px, of the unrectified image.
size_t PartOf(const cv::Point2d& left, const Lens& lens);

/// Where an adjustment ended.
struct AdjustmentEnd {
  const RawRig& rig;
  const std::vector<SceneMatch>& matches;
  const std::vector<double>& inverse_depths;
  const RigNumbers& change;
  double column_sigma_px = 1;  ///< scatters with which residuals were weighted, > 0
  double row_sigma_px = 1;
  double patch_sigmas = 1;  ///< in units of each patch's
};

/// Standard deviations; 0 of other numbers.
struct Deviations {
  RigNumbers if_others_stay{};  ///< of the free ones, if all else is as the calibration has it
  RigNumbers all{};             ///< of all wanted ones; the ToF camera may stand elsewhere, too
};

/// What the numbers that AdjustScene() found are known to (services/tools/calibrate/README.md, K5):
///  * matches near each other share errors, of all frames, and so do all of one frame: what the
///    numbers change by when a part of the image, or a frame, is left out (jackknife);
///  * a range sensor is off, at each range by something else, and the ToF camera may stand
///    elsewhere: neither is adjusted, nor averaged out by more matches.
/// @returns nothing when the matches do not determine the numbers. O(matches).
std::optional<Deviations> DeviationsOf(const AdjustmentEnd& end,
                                       const std::optional<EdgeShift>& edges, const Wanted& free,
                                       const Wanted& wanted);

}  // namespace sprout::calibrate
