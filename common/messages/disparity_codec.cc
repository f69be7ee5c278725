#include "common/messages/disparity_codec.h"

#include <bit>
#include <cstring>
#include <string>

#include "common/messages/compressor.h"

namespace sprout {
namespace {

static_assert(std::endian::native == std::endian::little,
              "counts are little-endian on the wire and are copied as they are");

size_t DisparityBytes(cv::Size size) {
  return sizeof(int16_t) * static_cast<size_t>(size.width) * static_cast<size_t>(size.height);
}

}  // namespace

std::vector<uint8_t> BytesOf(const cv::Mat& image) {
  const size_t row_bytes = image.elemSize() * static_cast<size_t>(image.cols);
  std::vector<uint8_t> bytes;
  bytes.reserve(row_bytes * static_cast<size_t>(image.rows));
  for (int v = 0; v < image.rows; ++v) {
    bytes.insert(bytes.end(), image.ptr(v), image.ptr(v) + row_bytes);
  }
  return bytes;
}

Result<DisparityImage> DecodeRawInt16(std::span<const uint8_t> data, cv::Size size) {
  if (data.size() != DisparityBytes(size)) {
    return Fail("size = " + std::to_string(data.size()) +
                ": allowed is 2 × width × height = " + std::to_string(DisparityBytes(size)));
  }
  DisparityImage disparity{cv::Mat1s(size)};
  std::memcpy(disparity.counts().data, data.data(), data.size());  // a new map has no gaps
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
  return CompressZstd(split);
}

Result<DisparityImage> DecodeDeltaZstd(std::span<const uint8_t> data, cv::Size size) {
  const auto split = DecompressZstd(data, DisparityBytes(size), "data", "2 × width × height");
  if (!split) return tl::unexpected(split.error());
  const size_t pixels = split->size() / 2;
  DisparityImage disparity{cv::Mat1s(size)};
  size_t i = 0;
  for (int v = 0; v < size.height; ++v) {
    uint16_t left = 0;
    for (int u = 0; u < size.width; ++u, ++i) {
      left = static_cast<uint16_t>(left + ((*split)[i] | ((*split)[pixels + i] << 8)));
      disparity.counts()(v, u) = static_cast<int16_t>(left);
    }
  }
  return disparity;
}

}  // namespace sprout
