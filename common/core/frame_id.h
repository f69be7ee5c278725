#pragma once

#include <compare>
#include <cstdint>
#include <string>

namespace sprout {

/// Identifies one capture; everything computed from it has the same FrameId.
struct FrameId {
  int64_t utime = 0;   ///< capture time, µs since 1970-01-01 UTC
  int64_t seq = -1;    ///< frame number from capture, +1 each; −1: no frame
  std::string rig_id;  ///< digest of the calibration, see RigId()

  auto operator<=>(const FrameId&) const = default;
};

}  // namespace sprout
