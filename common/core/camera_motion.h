#pragma once

#include <array>
#include <cstdint>

#include "common/core/pose.h"

namespace sprout {

/// Why a temporal stage forgot what it knew, and its motion is not known.
enum class MemoryReset : int8_t {
  kNone = 0,         ///< it did not
  kFirst = 1,        ///< the first frame
  kOtherRig = 2,     ///< another rig_id, or images of another size
  kBackwards = 3,    ///< seq or time went back
  kGap = 4,          ///< too long since the last frame
  kFewPoints = 5,    ///< too few points could be tracked
  kNoAgreement = 6,  ///< too few of them move as one
};
inline constexpr int kMemoryResets = 7;  ///< number of these

/// "NONE", "FIRST", ...: as motion_t's constants.
constexpr const char* NameOf(MemoryReset reset) {
  constexpr const char* kNames[kMemoryResets] = {"NONE", "FIRST",      "OTHER_RIG",   "BACKWARDS",
                                                 "GAP",  "FEW_POINTS", "NO_AGREEMENT"};
  return kNames[static_cast<int>(reset)];
}

/// How the left camera moved, from its images.
struct CameraMotion {
  Pose last_from_left;   ///< pose of the left camera in the frame it had at `last_seq`
  Pose start_from_left;  ///< and at `start_seq`
  /// Covariance of `last_from_left`: rotation vector (rad), then translation (m), in the frame of
  /// `last_seq`; row by row.
  std::array<double, 36> covariance{};
  int64_t last_seq = 0;   ///< the frame before; this one itself after a reset
  int64_t start_seq = 0;  ///< the frame of the newest reset
  int32_t tracked = 0;    ///< points found in both images
  int32_t inliers = 0;    ///< points that move as the motion says
  MemoryReset reset = MemoryReset::kFirst;
  int64_t resets = 0;  ///< since the stage began, without the first frame

  bool operator==(const CameraMotion&) const = default;
};

}  // namespace sprout
