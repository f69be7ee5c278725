#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace sprout {

/// An array of a message. Its elements have 1, 2 or 4 bytes.
struct PackedArray {
  size_t count = 0;
  size_t element_bytes = 1;
  size_t row = 0;  ///< elements of a row
  bool little_endian = false;

  size_t bytes() const { return count * element_bytes; }
};

/// Where the arrays of a message stand, which are all behind its other fields and without gaps.
struct PackedLayout {
  size_t head_bytes = 0;  ///< in front of them
  int32_t width = 0;      ///< of an image or map; else 0
  int32_t height = 0;
  size_t channels = 0;              ///< of an image, 1 or 3; else 0
  std::vector<PackedArray> arrays;  ///< of an image: its pixels
};

/// The layout of a message that can be packed; nothing when it cannot.
/// @param head     the message, or more than nothing of its beginning: head_bytes are enough.
/// @param message  bytes of the whole message, which the arrays fill.
std::optional<PackedLayout> LayoutOf(std::span<const uint8_t> head, size_t message_bytes);

/// Bytes of a message up to the end of its header: fingerprint, utime, seq, rig_id; nothing when
/// there are fewer.
std::optional<size_t> EndOfHeader(std::span<const uint8_t> message);

/// The fingerprint at an offset. @pre 8 bytes are there.
uint64_t FingerprintAt(std::span<const uint8_t> bytes, size_t offset);

/// Big-endian int32 at an offset; nothing behind the end.
std::optional<int32_t> Int32At(std::span<const uint8_t> bytes, size_t offset);

}  // namespace sprout
