#ifndef SPROUT_COMMON_RIG_RIG_FILE_H_
#define SPROUT_COMMON_RIG_RIG_FILE_H_

#include <filesystem>
#include <optional>

#include "common/core/result.h"
#include "common/rig/raw_rig.h"
#include "common/rig/rig.pb.h"

namespace sprout {

/// Reads a rig file (rig.proto, protobuf text format).
/// @throws ConfigError naming file, line or field, and what is allowed.
RigDescription LoadRigFile(const std::filesystem::path& path);

/// Writes a rig file; see OutputFile.
Result<void> SaveRigFile(const std::filesystem::path& path, const RigDescription& rig);

/// The calibration of a rig file; nothing when it has none yet.
/// @throws ConfigError naming the field that cannot be used.
std::optional<RawRig> CalibrationOf(const RigDescription& rig);

/// The same, but required.
/// @param path  of the file, for the message.
/// @throws ConfigError, also when there is none.
RawRig RequireCalibration(const RigDescription& rig, const std::filesystem::path& path);

/// The inverse of CalibrationOf().
RigCalibration ToCalibration(const RawRig& rig);

}  // namespace sprout

#endif  // SPROUT_COMMON_RIG_RIG_FILE_H_
