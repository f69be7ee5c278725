#pragma once

#include <string>

#include "common/core/checks.h"
#include "common/core/pose.h"
#include "common/core/result.h"
#include "common/core/rig.h"
#include "common/rig/range_correction.h"

namespace sprout {

/// A rig before rectification: lenses with distortion, an unrectified pair. Frames are x right, y
/// down, z forward. Rectifier turns it into a Rig.
struct RawRig {
  Lens left;
  Lens right;            ///< of the left one's size
  Pose left_from_right;  ///< of the right camera in the left one's frame
  Lens tof;              ///< 0×0 when there is no ToF camera
  Pose left_from_tof;    ///< of the ToF camera in the (unrectified) left camera's frame
  /// The ToF camera's bias: the range along the ray is scale · measured + offset (Hansard et al.,
  /// "Time-of-Flight Cameras", 2012).
  double range_scale = 1;
  double range_offset_m = 0;
  RangeCorrection range_correction = {};          ///< is added after that; a curve of the range
  AmplitudeCorrection amplitude_correction = {};  ///< as well; of the amplitude

  /// Whether ranges are right as they are measured.
  bool HasRightRanges() const {
    return range_scale == 1 && range_offset_m == 0 && range_correction.empty() &&
           amplitude_correction.empty();
  }
};

/// A ToF camera with this lens and this pose in the left rectified frame.
TofCamera TofCameraOf(const Lens& lens, const Pose& left_from_tof);

/// A camera rotated about its own place: rotation = exp(turn) · rotation. Nothing changes, to the
/// bit, when the turn is 0.
/// @param turn  rotation vector, rad, in the frame that the pose is given in.
Pose TurnedBy(const Pose& pose, const Eigen::Vector3d& turn);

/// Whether a calibration can be used: possible numbers (CheckLens()), invertible distortion, images
/// of one size, at least 2×2 px, rotations of norm 1, the right camera to the right of the left
/// one, not above or below it; and whether the rectified images show enough of what both cameras
/// see. The error names the first wrong field, by its name in rig.proto. O(1).
Result<void> CheckRawRig(const RawRig& rig);

/// Its checks of one camera and of one pose; `name` stands before the fields in the error.
void CheckCamera(Checks& checks, const std::string& name, const Lens& lens);
void CheckPose(Checks& checks, const std::string& name, const Pose& pose);

}  // namespace sprout
