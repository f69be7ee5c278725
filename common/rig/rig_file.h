#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "common/core/result.h"
#include "common/rig/raw_rig.h"
#include "common/rig/rig.pb.h"

namespace sprout {

/// Reads a rig file (rig.proto, protobuf text format).
/// @throws ConfigError naming file, line or field, and what is allowed.
RigDescription LoadRigFile(const std::filesystem::path& path);

/// Writes a rig file; see OutputFile. It may be the one that was read: a rig is put right in place.
/// Comments of a file that is replaced stand at the begin of the new one, those behind a value with
/// the old value.
Result<void> SaveRigFile(const std::filesystem::path& path, const RigDescription& rig);

/// The calibration of a rig file; nothing when it has none yet.
/// @throws ConfigError naming the field that cannot be used.
std::optional<RawRig> CalibrationOf(const RigDescription& rig);

/// The board's calibration of a rig file: board_calibration or, without one, calibration.
/// @throws ConfigError naming the field that cannot be used.
std::optional<RawRig> BoardCalibrationOf(const RigDescription& rig);

/// The same as CalibrationOf(), but required.
/// @param path  of the file, for the message.
/// @throws ConfigError, also when there is none.
RawRig RequireCalibration(const RigDescription& rig, const std::filesystem::path& path);

/// The ToF camera of a rig file whose calibration has `tof` and `left_from_tof`, but no other
/// cameras: its pose is that in the left rectified frame.
/// @param path  of the file, for the message.
/// @throws ConfigError naming what is missing or cannot be used.
TofCamera TofCameraOf(const RigDescription& rig, const std::filesystem::path& path);

/// A camera of the rig file that is not one of the rig's three.
struct OtherCameraPlace {
  Lens lens;
  Pose left_from_camera;  ///< in the left rectified frame
};

/// Where other cameras are, and where the rig is on the robot.
struct RigPlaces {
  std::optional<RectifiedPair> pair;   ///< of the file's calibration; nothing when it has none yet
  std::optional<Pose> base_from_left;  ///< of the left rectified camera in the robot's frame
  std::map<std::string, OtherCameraPlace> others;  ///< by name
};

/// @param path  of the file, for the message.
/// @throws ConfigError naming the field that cannot be used.
RigPlaces PlacesOf(const RigDescription& rig, const std::filesystem::path& path);

/// The inverse of CalibrationOf().
RigCalibration ToCalibration(const RawRig& rig);

}  // namespace sprout
