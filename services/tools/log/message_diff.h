#ifndef SPROUT_SERVICES_TOOLS_LOG_MESSAGE_DIFF_H_
#define SPROUT_SERVICES_TOOLS_LOG_MESSAGE_DIFF_H_

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "common/core/disparity_diff.h"

namespace sprout::log {

/// Result of comparing two messages with different bytes.
struct MessageDiff {
  bool equal = false;  ///< same header and values, encoded differently
  std::string text;    ///< what differs, one line
  std::optional<DisparityDiff> disparity;
};

/// Compares by content if both decode as the same type of Sprout's. O(bytes).
MessageDiff Compare(std::span<const uint8_t> a, std::span<const uint8_t> b);

}  // namespace sprout::log

#endif  // SPROUT_SERVICES_TOOLS_LOG_MESSAGE_DIFF_H_
