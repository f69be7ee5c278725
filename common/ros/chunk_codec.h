#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "common/core/result.h"
#include "common/ros/mcap_format.h"

namespace sprout {

/// Packs the records of a chunk with zstd. @param packed  is overwritten; its memory is used again.
void PackChunk(std::span<const uint8_t> records, McapBytes& packed);

/// A chunk that is larger than this, bytes, is not unpacked.
inline constexpr uint64_t kMaxMcapChunkBytes = uint64_t{1} << 30;
/// A record that is larger than this, bytes, is not read: a chunk that compression made larger.
inline constexpr uint64_t kMaxMcapRecordBytes = kMaxMcapChunkBytes + (uint64_t{1} << 24);

/// The records of a chunk: `size` bytes, of which memory is taken only as they come out.
/// @param compression  as in the file.
Result<McapBytes> UnpackChunk(std::string_view compression, std::span<const uint8_t> packed,
                              uint64_t size);

/// The records of a chunk, from the content of its own record: unpacked, and its CRC compared.
Result<McapBytes> UnpackChunkRecord(std::span<const uint8_t> content);

/// Whether bytes begin as a Zstandard frame does; CDR never does.
bool IsZstd(std::span<const uint8_t> bytes);

/// A message that rosbag2 packed by itself (--compression-mode message): one Zstandard frame, which
/// need not say how long its content is; memory is taken only as it comes out.
Result<McapBytes> UnpackMessage(std::span<const uint8_t> packed);

}  // namespace sprout
