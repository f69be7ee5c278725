#include "common/ros/chunk_codec.h"

#include <lz4frame.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <memory>
#include <stdexcept>
#include <string>

namespace sprout {
namespace {

// Memory grows by so much while a chunk is unpacked: a few bytes could claim a gigabyte.
constexpr size_t kStep = size_t{4} << 20;

struct ZstdReaderDeleter {
  void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
};
struct Lz4ReaderDeleter {
  void operator()(LZ4F_dctx* context) const { LZ4F_freeDecompressionContext(context); }
};

// Unpacks piece by piece into bytes that grow. `step` takes what is packed and room for what comes
// out, and leaves how much of each was used. @returns false when it fails.
template <typename Step>
Result<McapBytes> UnpackSteps(std::span<const uint8_t> packed, uint64_t size, const Step& step) {
  McapBytes bytes;
  size_t filled = 0;
  while (true) {
    if (filled == bytes.size()) bytes.resize(std::min<uint64_t>(size, filled + kStep));
    size_t taken = packed.size();
    size_t made = bytes.size() - filled;
    if (!step(packed.data(), taken, bytes.data() + filled, made)) {
      return Fail("chunk: cannot be unpacked");
    }
    packed = packed.subspan(taken);
    filled += made;
    if (taken == 0 && made == 0) break;
  }
  if (filled != size || !packed.empty()) {
    return Fail("chunk: unpacks to other than " + std::to_string(size) + " bytes");
  }
  return bytes;
}

Result<McapBytes> UnpackZstd(std::span<const uint8_t> packed, uint64_t size) {
  const std::unique_ptr<ZSTD_DCtx, ZstdReaderDeleter> context(ZSTD_createDCtx());
  return UnpackSteps(packed, size,
                     [&](const uint8_t* from, size_t& taken, uint8_t* to, size_t& made) {
                       ZSTD_inBuffer in{from, taken, 0};
                       ZSTD_outBuffer out{to, made, 0};
                       const size_t result = ZSTD_decompressStream(context.get(), &out, &in);
                       taken = in.pos;
                       made = out.pos;
                       return ZSTD_isError(result) == 0;
                     });
}

Result<McapBytes> UnpackLz4(std::span<const uint8_t> packed, uint64_t size) {
  LZ4F_dctx* opened = nullptr;
  LZ4F_createDecompressionContext(&opened, LZ4F_VERSION);
  const std::unique_ptr<LZ4F_dctx, Lz4ReaderDeleter> context(opened);
  if (!context) return Fail("chunk: no memory");
  return UnpackSteps(
      packed, size, [&](const uint8_t* from, size_t& taken, uint8_t* to, size_t& made) {
        return LZ4F_isError(LZ4F_decompress(context.get(), to, &made, from, &taken, nullptr)) == 0;
      });
}

}  // namespace

void PackChunk(std::span<const uint8_t> records, McapBytes& packed) {
  constexpr int kLevel = 1;
  packed.resize(ZSTD_compressBound(records.size()));
  const size_t size =
      ZSTD_compress(packed.data(), packed.size(), records.data(), records.size(), kLevel);
  if (ZSTD_isError(size) != 0) {
    throw std::runtime_error("zstd: " + std::string(ZSTD_getErrorName(size)));
  }
  packed.resize(size);
}

Result<McapBytes> UnpackChunk(std::string_view compression, std::span<const uint8_t> packed,
                              uint64_t size) {
  if (size > kMaxMcapChunkBytes) {
    return Fail("chunk of " + std::to_string(size) + " bytes: allowed are up to " +
                std::to_string(kMaxMcapChunkBytes));
  }
  if (compression == "zstd") return UnpackZstd(packed, size);
  if (compression == "lz4") return UnpackLz4(packed, size);
  if (!compression.empty()) {
    return Fail("chunk with compression '" + std::string(compression.substr(0, 32)) +
                "': allowed are zstd, lz4 and none");
  }
  if (packed.size() != size) return Fail("chunk: other than " + std::to_string(size) + " bytes");
  return McapBytes(packed.begin(), packed.end());
}

Result<McapBytes> UnpackChunkRecord(std::span<const uint8_t> content) {
  RecordReader reader(content);
  reader.Number<uint64_t>();  // times
  reader.Number<uint64_t>();
  const auto size = reader.Number<uint64_t>();
  const auto crc = reader.Number<uint32_t>();
  const std::string compression = reader.Text();
  const std::span packed = reader.Raw(reader.Number<uint64_t>());
  if (!reader.ok()) return Fail("chunk: not whole");
  Result<McapBytes> chunk = UnpackChunk(compression, packed, size);
  if (chunk && crc != 0 && Crc32(0, *chunk) != crc) return Fail("chunk: its CRC is another");
  return chunk;
}

bool IsZstd(std::span<const uint8_t> bytes) {
  constexpr std::array<uint8_t, 4> kMagic = {0x28, 0xb5, 0x2f, 0xfd};
  return bytes.size() >= kMagic.size() && std::ranges::equal(bytes.first(kMagic.size()), kMagic);
}

Result<McapBytes> UnpackMessage(std::span<const uint8_t> packed) {
  const std::unique_ptr<ZSTD_DCtx, ZstdReaderDeleter> context(ZSTD_createDCtx());
  McapBytes bytes;
  ZSTD_inBuffer in{packed.data(), packed.size(), 0};
  size_t result = 1;
  for (size_t filled = 0; result != 0;) {
    if (bytes.size() >= kMaxMcapChunkBytes) return Fail("message: unpacks to too many bytes");
    bytes.resize(std::min<uint64_t>(kMaxMcapChunkBytes, filled + kStep));
    ZSTD_outBuffer out{bytes.data() + filled, bytes.size() - filled, 0};
    result = ZSTD_decompressStream(context.get(), &out, &in);
    filled += out.pos;
    // Nothing is left to take in, and it wants more: it was torn off.
    const bool is_torn = result != 0 && in.pos == in.size && out.pos < out.size;
    if (ZSTD_isError(result) != 0 || is_torn) return Fail("message: cannot be unpacked");
    if (result == 0) bytes.resize(filled);
  }
  if (in.pos != in.size) return Fail("message: bytes behind what was packed");
  return bytes;
}

}  // namespace sprout
