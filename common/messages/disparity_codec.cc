#include "common/messages/disparity_codec.h"

#include <zstd.h>

#include <bit>
#include <cstring>
#include <string>

namespace sprout {
namespace {

// Level −1 of zstd: at 2 MP level 1 takes half as long again for a tenth fewer bytes.
constexpr int kZstdLevel = -1;

static_assert(std::endian::native == std::endian::little,
              "counts are little-endian on the wire and are copied as they are");

size_t RowBytes(cv::Size size) { return static_cast<size_t>(size.width) * sizeof(int16_t); }

size_t MapBytes(cv::Size size) { return RowBytes(size) * static_cast<size_t>(size.height); }

}  // namespace

std::vector<uint8_t> EncodeRawInt16(const DisparityImage& disparity) {
  const size_t row_bytes = RowBytes(disparity.size());
  std::vector<uint8_t> data(MapBytes(disparity.size()));
  for (int v = 0; v < disparity.height(); ++v) {
    std::memcpy(&data[static_cast<size_t>(v) * row_bytes], disparity.counts()[v], row_bytes);
  }
  return data;
}

Result<DisparityImage> DecodeRawInt16(std::span<const uint8_t> data, cv::Size size) {
  if (data.size() != MapBytes(size)) {
    return Fail("size = " + std::to_string(data.size()) +
                ": allowed is 2 × width × height = " + std::to_string(MapBytes(size)));
  }
  DisparityImage disparity{cv::Mat1s(size)};
  for (int v = 0; v < size.height; ++v) {
    std::memcpy(disparity.counts()[v], data.data() + static_cast<size_t>(v) * RowBytes(size),
                RowBytes(size));
  }
  return disparity;
}

std::vector<uint8_t> EncodeDeltaZstd(const DisparityImage& disparity) {
  const size_t pixels = disparity.counts().total();
  std::vector<uint8_t> split(2 * pixels);
  size_t i = 0;
  for (int v = 0; v < disparity.height(); ++v) {
    uint16_t left = 0;
    for (int u = 0; u < disparity.width(); ++u, ++i) {
      const auto count = static_cast<uint16_t>(disparity.counts()(v, u));
      const auto delta = static_cast<uint16_t>(count - left);
      split[i] = static_cast<uint8_t>(delta & 0xff);
      split[pixels + i] = static_cast<uint8_t>(delta >> 8);
      left = count;
    }
  }
  std::vector<uint8_t> data(ZSTD_compressBound(split.size()));
  data.resize(ZSTD_compress(data.data(), data.size(), split.data(), split.size(), kZstdLevel));
  return data;
}

Result<DisparityImage> DecodeDeltaZstd(std::span<const uint8_t> data, cv::Size size) {
  // Before anything is allocated: the frame must declare the map's size, and not promise more than
  // the format can deliver (a block of 128 KiB takes at least 4 bytes).
  const size_t pixels = MapBytes(size) / sizeof(int16_t);
  constexpr size_t kMaxRatio = 128 * 1024 / 4;
  if (ZSTD_getFrameContentSize(data.data(), data.size()) != MapBytes(size) ||
      MapBytes(size) / kMaxRatio > data.size()) {
    return Fail("data: not a Zstandard frame of 2 × width × height = " +
                std::to_string(MapBytes(size)) + " bytes");
  }
  if (ZSTD_findFrameCompressedSize(data.data(), data.size()) != data.size()) {
    return Fail("data: damaged Zstandard frame, or bytes behind it");
  }
  std::vector<uint8_t> split(2 * pixels);
  const size_t decoded = ZSTD_decompress(split.data(), split.size(), data.data(), data.size());
  if (ZSTD_isError(decoded)) {
    return Fail(std::string("data: damaged Zstandard frame (") + ZSTD_getErrorName(decoded) + ")");
  }
  DisparityImage disparity{cv::Mat1s(size)};
  size_t i = 0;
  for (int v = 0; v < size.height; ++v) {
    uint16_t left = 0;
    for (int u = 0; u < size.width; ++u, ++i) {
      left = static_cast<uint16_t>(left + (split[i] | (split[pixels + i] << 8)));
      disparity.counts()(v, u) = static_cast<int16_t>(left);
    }
  }
  return disparity;
}

}  // namespace sprout
