#ifndef SPROUT_COMMON_MESSAGES_ZSTD_FRAME_H_
#define SPROUT_COMMON_MESSAGES_ZSTD_FRAME_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/core/result.h"

namespace sprout {

/// The bytes as one Zstandard frame that declares their number.
std::vector<uint8_t> CompressZstd(std::span<const uint8_t> bytes);

/// The inverse. Before it allocates memory it checks that `data` is one whole frame, with nothing
/// after it, that declares exactly `size` bytes and is not too short to hold them.
/// @param field   of the message, for the error: "data".
/// @param pixels  what the size must be, for the error: "2 × width × height".
Result<std::vector<uint8_t>> DecompressZstd(std::span<const uint8_t> data, size_t size,
                                            const std::string& field, const std::string& pixels);

}  // namespace sprout

#endif  // SPROUT_COMMON_MESSAGES_ZSTD_FRAME_H_
