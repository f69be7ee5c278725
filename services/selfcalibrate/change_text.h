#ifndef SPROUT_SERVICES_SELFCALIBRATE_CHANGE_TEXT_H_
#define SPROUT_SERVICES_SELFCALIBRATE_CHANGE_TEXT_H_

#include <string>

#include "common/core/rig.h"
#include "common/core/rig_change.h"
#include "common/core/stage_status.h"
#include "common/rig/range_correction.h"

namespace sprout::selfcalibrate {

/// A result as one line: figures with their standard deviations, px in the middle of the image, or
/// why nothing is seen.
std::string ChangeText(const RigChange& change, const RectifiedPair& pair);

/// What to do about a wrong calibration, one line.
/// @param applied  whether capture is asked to change it.
std::string AdviceText(bool applied);

/// What has to be added to the ranges (a curve that is not empty), at its nearest and farthest knot
/// and where it is most, with standard deviations, and what to do, one line.
std::string CurveText(const RangeCorrection& curve);

/// The ToF camera's turn as a shift of its points in the middle of the left image.
TofOffsetStatus OffsetOf(const RigChange& change, const RectifiedPair& pair);

}  // namespace sprout::selfcalibrate

#endif  // SPROUT_SERVICES_SELFCALIBRATE_CHANGE_TEXT_H_
