#include "common/messages/jpeg.h"

#include <turbojpeg.h>

#include <algorithm>
#include <memory>
#include <stdexcept>

#include "common/core/image.h"

namespace sprout {
namespace {

struct HandleDeleter {
  void operator()(void* handle) const { tjDestroy(handle); }
};
using Handle = std::unique_ptr<void, HandleDeleter>;

tl::unexpected<Error> Undecodable(const Handle& decoder) {
  return Fail(std::string("data: not a whole JPEG stream (") + tjGetErrorStr2(decoder.get()) + ")");
}

// At least as many scans as libjpeg will find: each starts with the marker SOS, FF DA, which cannot
// stand between entropy-coded bytes. In a comment or a thumbnail it may.
size_t CountScanMarkers(std::span<const uint8_t> data) {
  size_t count = 0;
  for (size_t i = 1; i < data.size(); ++i) count += data[i - 1] == 0xff && data[i] == 0xda ? 1 : 0;
  return count;
}

}  // namespace

Result<cv::Mat> DecodeJpeg(std::span<const uint8_t> data, std::optional<cv::Size> allowed) {
  const Handle decoder(tjInitDecompress());
  if (!decoder) return Fail("data: no JPEG decoder, out of memory");
  const auto bytes = static_cast<unsigned long>(data.size());
  int width = 0;
  int height = 0;
  int subsampling = 0;
  int colour_space = 0;
  if (tjDecompressHeader3(decoder.get(), data.data(), bytes, &width, &height, &subsampling,
                          &colour_space) != 0) {
    return Undecodable(decoder);
  }
  const cv::Size size(width, height);
  if (allowed && size != *allowed) {
    return Fail("data: JPEG of " + SizeText(size) +
                ", allowed is width x height = " + SizeText(*allowed));
  }
  if (std::max(width, height) > kMaxSide || int64_t{width} * height > kMaxPixels) {
    return Fail("data: JPEG of " + SizeText(size) + ", allowed is up to " +
                std::to_string(kMaxSide) + " px a side and " + std::to_string(kMaxPixels) +
                " pixels");
  }
  if (int64_t{width} * height / kMaxJpegPixelsPerByte > static_cast<int64_t>(data.size())) {
    return Fail("data: JPEG of " + SizeText(size) + " in " + std::to_string(data.size()) +
                " bytes: allowed is at least one for " + std::to_string(kMaxJpegPixelsPerByte) +
                " pixels");
  }
  if (const size_t scans = CountScanMarkers(data); scans > kMaxJpegScans) {
    return Fail("data: JPEG of " + std::to_string(scans) + " scans: allowed are up to " +
                std::to_string(kMaxJpegScans));
  }
  const bool grey = colour_space == TJCS_GRAY;
  cv::Mat image(size, grey ? CV_8UC1 : CV_8UC3);
  if (tjDecompress2(decoder.get(), data.data(), bytes, image.data, width,
                    static_cast<int>(image.step), height, grey ? TJPF_GRAY : TJPF_BGR,
                    TJFLAG_STOPONWARNING) != 0) {
    return Undecodable(decoder);
  }
  return image;
}

std::string WriteJpeg(const cv::Mat& picture, JpegColors colors, int quality) {
  const Handle handle(tjInitCompress());
  if (!handle) throw std::runtime_error("JPEG: no compressor");
  const bool grey = picture.channels() == 1;
  const int sampling = grey ? TJSAMP_GRAY : colors == JpegColors::kFull ? TJSAMP_444 : TJSAMP_420;
  std::string stream(tjBufSize(picture.cols, picture.rows, sampling), '\0');
  auto* data = reinterpret_cast<unsigned char*>(stream.data());
  unsigned long size = stream.size();  // NOLINT: as libjpeg-turbo has it
  if (tjCompress2(handle.get(), picture.data, picture.cols, static_cast<int>(picture.step),
                  picture.rows, grey ? TJPF_GRAY : TJPF_BGR, &data, &size, sampling, quality,
                  TJFLAG_NOREALLOC | TJFLAG_FASTDCT) != 0) {
    throw std::runtime_error(std::string("JPEG: ") + tjGetErrorStr2(handle.get()));
  }
  stream.resize(size);
  stream.shrink_to_fit();  // libjpeg asks for room for the worst of pictures, often 20 times this
  return stream;
}

}  // namespace sprout
