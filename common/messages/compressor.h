#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/core/result.h"
#include "common/messages/packed.h"

namespace sprout {

/// Messages of the graph in fewer bytes, which every reader of Sprout's takes. One object serves
/// one thread at a time.
class MessageCompressor {
 public:
  /// @param jpeg_quality  1 to 100: images of the cameras become JPEG, about a tenth of their size,
  ///                      which loses something; nothing: all is packed without loss.
  explicit MessageCompressor(std::optional<int> jpeg_quality = std::nullopt)
      : jpeg_quality_(jpeg_quality) {}

  /// @param channel  with any prefix.
  /// @returns the message in fewer bytes; nothing when it stays as it is, as all of other programs
  ///          do.
  /// @throws std::runtime_error when a library refuses.
  std::optional<std::vector<uint8_t>> Compress(std::string_view channel,
                                               std::span<const uint8_t> message);

 private:
  std::optional<int> jpeg_quality_;
  MessagePacker packer_;
};

/// The bytes as one Zstandard frame that declares their number.
std::vector<uint8_t> CompressZstd(std::span<const uint8_t> bytes);

/// The inverse. Before it allocates memory it checks that `data` is one whole frame, with nothing
/// after it, that declares exactly `size` bytes and is not too short to hold them.
/// @param field   of the message, for the error: "data".
/// @param pixels  what the size must be, for the error: "2 × width × height".
Result<std::vector<uint8_t>> DecompressZstd(std::span<const uint8_t> data, size_t size,
                                            const std::string& field, const std::string& pixels);

}  // namespace sprout
