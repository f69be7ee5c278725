#ifndef SPROUT_COMMON_MESSAGES_COMPRESSOR_H_
#define SPROUT_COMMON_MESSAGES_COMPRESSOR_H_

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

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

}  // namespace sprout

#endif  // SPROUT_COMMON_MESSAGES_COMPRESSOR_H_
