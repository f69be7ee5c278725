#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core/types.hpp>
#include <optional>
#include <span>
#include <vector>

#include "common/core/result.h"

namespace sprout {

/// Makes messages with images, maps, seeds or points smaller, without loss: packed_t.
/// DecodePart(), TypeOf() and DecodeFrameId() take packed messages as they take others.
/// Keeps its memory from message to message, so one object serves one thread at a time.
class MessagePacker {
 public:
  MessagePacker();
  ~MessagePacker();
  MessagePacker(const MessagePacker&) = delete;
  MessagePacker& operator=(const MessagePacker&) = delete;

  /// The packed message; nothing when it is of another type or encoding, or has rows with gaps, or
  /// would not become smaller. O(bytes): some 200 MB/s of an image, see services/record/NOTES.md.
  std::optional<std::vector<uint8_t>> Pack(std::span<const uint8_t> message);

 private:
  struct Scratch;
  std::unique_ptr<Scratch> scratch_;
};

/// Whether a message is a packed one.
bool IsPacked(std::span<const uint8_t> message);

/// First 8 bytes of the message that is packed in this one; nothing when it is too short.
/// @pre IsPacked(message).
std::optional<uint64_t> PackedFingerprint(std::span<const uint8_t> message);

/// Whether a compressed picture or map may be of a size.
/// @param expected  as in DecodePart().
Result<void> CheckCompressedSize(cv::Size size, std::optional<cv::Size> expected);

/// The very message that was packed. Accepts arbitrary bytes: what does not fit gives an error
/// before memory is allocated for it.
/// @param expected  as in DecodePart().
Result<std::vector<uint8_t>> Unpack(std::span<const uint8_t> message,
                                    std::optional<cv::Size> expected = std::nullopt);

}  // namespace sprout
