#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "common/core/result.h"
#include "common/ros/mcap_format.h"

namespace sprout {

/// Compresses chunks, one after the other; its contexts are used again. Not thread-safe.
class ChunkPacker {
 public:
  /// @param zstd_level  see zstd's manual; below 0: faster and larger.
  explicit ChunkPacker(McapCompression compression, int zstd_level);
  ~ChunkPacker();

  /// @returns the bytes as the chunk holds them, valid until the next call.
  std::span<const uint8_t> Pack(std::span<const uint8_t> bytes);

  McapCompression compression() const { return compression_; }

 private:
  struct Contexts;
  McapCompression compression_;
  int zstd_level_;
  std::unique_ptr<Contexts> contexts_;
  McapBytes packed_;
};

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
