#ifndef SPROUT_COMMON_CORE_FRAME_RANGE_H_
#define SPROUT_COMMON_CORE_FRAME_RANGE_H_

#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>

namespace sprout {

/// Frame numbers (seq) from first to last, both included; all of them unless told otherwise.
struct FrameRange {
  int64_t first = 0;
  int64_t last = std::numeric_limits<int64_t>::max();

  bool Contains(int64_t seq) const { return seq >= first && seq <= last; }
  bool operator==(const FrameRange&) const = default;
};

/// Reads "A:B"; either number may be left out for an open end ("A:", ":B"), and "A" is one frame.
/// @returns nothing when the text is none of these, or when A > B.
std::optional<FrameRange> ParseFrameRange(std::string_view text);

}  // namespace sprout

#endif  // SPROUT_COMMON_CORE_FRAME_RANGE_H_
