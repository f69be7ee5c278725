#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "common/core/disparity_diff.h"
#include "services/tools/log/log_frames.h"

namespace sprout::log {

/// Result of comparing two messages with different bytes.
struct MessageDiff {
  bool equal = false;  ///< same header and values, encoded differently
  std::string text;    ///< what differs, one line
  std::optional<DisparityDiff> disparity;
};

/// Compares by content if both decode as the same type of Sprout's. O(bytes).
MessageDiff Compare(std::span<const uint8_t> a, std::span<const uint8_t> b);

/// Writes pictures of the difference of two messages of one channel and frame:
/// "000042_CHANNEL_a.png", "_b.png" and "_difference.png". Only for disparity maps, priors and
/// images of one size.
/// @throws std::runtime_error naming path and reason; ConfigError when the folder cannot be made.
void WriteDifferencePictures(std::span<const uint8_t> a, std::span<const uint8_t> b,
                             const std::string& channel, FrameFileNames& names);

}  // namespace sprout::log
