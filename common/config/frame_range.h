#pragma once

#include <cstdint>
#include <limits>
#include <string>

namespace sprout {

/// Frames by their number (header.seq), both ends included.
struct FrameRange {
  int64_t first = 0;
  int64_t last = std::numeric_limits<int64_t>::max();

  bool Has(int64_t seq) const { return seq >= first && seq <= last; }
  bool operator==(const FrameRange&) const = default;
};

/// Reads "A:B" (frames A to B, both included), "A:", ":B" or "A" (that one).
/// @throws ConfigError naming `flag`.
FrameRange ParseFrameRange(const std::string& flag, const std::string& text);

}  // namespace sprout
