#ifndef SPROUT_SERVICES_LOG_MESSAGE_DIFF_H_
#define SPROUT_SERVICES_LOG_MESSAGE_DIFF_H_

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "common/core/disparity_diff.h"

namespace sprout::log {

/// What came out when two messages with different bytes were compared.
struct MessageDiff {
  bool equal = false;  ///< same header and values, encoded differently
  std::string text;    ///< what differs, one line
  std::optional<DisparityDiff> disparity;
};

/// Compares by content where both decode as one type of ours. O(bytes).
MessageDiff Compare(std::span<const uint8_t> a, std::span<const uint8_t> b);

}  // namespace sprout::log

#endif  // SPROUT_SERVICES_LOG_MESSAGE_DIFF_H_
