#include "common/messages/zstd_frame.h"

#include <zstd.h>

namespace sprout {
namespace {

// Level −1 of zstd: at 2 MP level 1 takes half as long again for a tenth fewer bytes.
constexpr int kZstdLevel = -1;

// Most that the format can deliver a byte: a block of 128 KiB takes at least 4 bytes.
constexpr size_t kMaxRatio = 128 * 1024 / 4;

}  // namespace

std::vector<uint8_t> CompressZstd(std::span<const uint8_t> bytes) {
  std::vector<uint8_t> data(ZSTD_compressBound(bytes.size()));
  data.resize(ZSTD_compress(data.data(), data.size(), bytes.data(), bytes.size(), kZstdLevel));
  return data;
}

Result<std::vector<uint8_t>> DecompressZstd(std::span<const uint8_t> data, size_t size,
                                            const std::string& field, const std::string& pixels) {
  if (ZSTD_getFrameContentSize(data.data(), data.size()) != size ||
      size / kMaxRatio > data.size()) {
    return Fail(field + ": not a Zstandard frame of " + pixels + " = " + std::to_string(size) +
                " bytes");
  }
  if (ZSTD_findFrameCompressedSize(data.data(), data.size()) != data.size()) {
    return Fail(field + ": damaged Zstandard frame, or bytes behind it");
  }
  std::vector<uint8_t> bytes(size);
  const size_t decoded = ZSTD_decompress(bytes.data(), bytes.size(), data.data(), data.size());
  if (ZSTD_isError(decoded)) {
    return Fail(field + ": damaged Zstandard frame (" + ZSTD_getErrorName(decoded) + ")");
  }
  return bytes;
}

}  // namespace sprout
