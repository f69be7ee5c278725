#ifndef SPROUT_COMMON_RIG_CHANGED_RIG_H_
#define SPROUT_COMMON_RIG_CHANGED_RIG_H_

#include "common/core/result.h"
#include "common/core/rig_change.h"
#include "common/rig/raw_rig.h"
#include "common/rig/rectification.h"
#include "common/rig/rig.pb.h"

namespace sprout {

/// A rig with a change that was seen in its rectified images. What the change does not show stays.
/// @param made  how these images were rectified: RectificationOf(rig).
RawRig ChangedRig(const RawRig& rig, const Rectification& made, const RigChange& change);

/// Whether a rig is within the limits from the board's calibration; the error names the number that
/// is not, and what to do.
Result<void> CheckLimits(const RawRig& rig, const RawRig& board,
                         const SelfCalibrationLimits& limits);

}  // namespace sprout

#endif  // SPROUT_COMMON_RIG_CHANGED_RIG_H_
