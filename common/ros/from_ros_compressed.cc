#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "common/core/depth_of_counts.h"
#include "common/core/image.h"
#include "common/messages/jpeg.h"
#include "common/ros/from_ros.h"

namespace sprout {
namespace {

using namespace std::string_view_literals;
using Bytes = std::span<const uint8_t>;

bool BeginsWith(Bytes bytes, std::string_view magic) {
  return std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size())
      .starts_with(magic);
}

bool IsJpeg(Bytes bytes) { return BeginsWith(bytes, "\xff\xd8\xff"sv); }
bool IsPng(Bytes bytes) { return BeginsWith(bytes, "\x89PNG\r\n\x1a\n"sv); }

uint32_t BigEndian(Bytes bytes, size_t at) {
  uint32_t number = 0;
  for (size_t i = 0; i < sizeof number; ++i) number = number << 8 | bytes[at + i];
  return number;
}

// The picture as it is stored; its size is checked before OpenCV takes memory for it.
Result<cv::Mat> DecodePng(Bytes bytes, std::optional<cv::Size> size) {
  constexpr size_t kWidthAt = 16;  // in the first chunk, IHDR (PNG, 11.2.2)
  constexpr size_t kHeaderEnd = 24;
  if (bytes.size() < kHeaderEnd) return Fail("data: not a whole PNG stream");
  const uint32_t width = BigEndian(bytes, kWidthAt);
  const uint32_t height = BigEndian(bytes, kWidthAt + 4);
  const bool is_possible = std::max(width, height) <= static_cast<uint32_t>(kMaxSide) &&
                           uint64_t{width} * height <= static_cast<uint64_t>(kMaxPixels);
  const cv::Size of_header(is_possible ? static_cast<int>(width) : 0,
                           is_possible ? static_cast<int>(height) : 0);
  if (!is_possible || (size && of_header != *size)) {
    return Fail("data: PNG of " + std::to_string(width) + "x" + std::to_string(height) +
                ", allowed is " +
                (size ? "width x height = " + SizeText(*size)
                      : "up to " + std::to_string(kMaxSide) + " px a side"));
  }
  cv::Mat image;
  try {
    const cv::Mat stream(1, static_cast<int>(bytes.size()), CV_8UC1,
                         const_cast<uint8_t*>(bytes.data()));  // NOLINT: is not written to
    image = cv::imdecode(stream, cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception&) {  // an empty image says it all
  }
  if (image.empty() || image.size() != of_header) return Fail("data: not a whole PNG stream");
  return image;
}

// What a driver calls the image before it was compressed: "bayer_rggb8; png compressed ".
std::string_view OriginalEncoding(std::string_view format) {
  return format.substr(0, std::min(format.find(';'), format.size()));
}

tl::unexpected<Error> UnknownFormat(const RosCompressedImage& ros, const std::string& allowed) {
  return Fail("format = '" + std::string(std::string_view(RosText(ros.format)).substr(0, 64)) +
              "': its data is none that can be read; allowed is " + allowed);
}

// image_transport's parameters of compressedDepth: an enumeration, then the two of the quantisation
// of inverse depths, value = a / depth + b.
struct DepthParameters {
  static constexpr size_t kBytes = 12;
  float a = 0;
  float b = 0;
};

DepthParameters ParametersOf(Bytes bytes) {
  DepthParameters parameters;
  std::memcpy(&parameters.a, bytes.data() + 4, sizeof parameters.a);
  std::memcpy(&parameters.b, bytes.data() + 8, sizeof parameters.b);
  return parameters;
}

cv::Mat1f FromInverse(const cv::Mat1w& values, const DepthParameters& parameters) {
  cv::Mat1f depth_m(values.size());
  std::transform(values.begin(), values.end(), depth_m.begin(), [&](uint16_t value) {
    return value == 0 ? std::numeric_limits<float>::quiet_NaN()
                      : parameters.a / (static_cast<float>(value) - parameters.b);
  });
  return depth_m;
}

}  // namespace

Result<cv::Mat> FromRosImage(const RosCompressedImage& ros, std::optional<cv::Size> size) {
  const Bytes data = RosSpan(ros.data);
  Result<cv::Mat> stored;
  if (IsJpeg(data)) {
    stored = DecodeJpeg(data, size);
  } else if (IsPng(data)) {
    stored = DecodePng(data, size);
  } else {
    return UnknownFormat(ros, "JPEG or PNG");
  }
  if (!stored) return stored;
  return ToPicture(*stored, OriginalEncoding(RosText(ros.format)));
}

Result<cv::Mat1f> FromRosDepth(const RosCompressedImage& ros, std::optional<cv::Size> size) {
  Bytes data = RosSpan(ros.data);
  std::optional<DepthParameters> parameters;
  if (!IsPng(data) && data.size() > DepthParameters::kBytes) {
    parameters = ParametersOf(data);
    data = data.subspan(DepthParameters::kBytes);
  }
  if (!IsPng(data)) {
    return UnknownFormat(ros, "a PNG of 16 bits, as compressedDepth sends it with format: png");
  }
  const Result<cv::Mat> stored = DecodePng(data, size);
  if (!stored) return tl::unexpected(stored.error());
  if (stored->type() != CV_16UC1) {
    return Fail("data: PNG of " + std::to_string(stored->channels()) + " channels and " +
                std::to_string(8 * stored->elemSize1()) + " bits: allowed is one of 16 bits");
  }
  if (OriginalEncoding(RosText(ros.format)) == "32FC1") {
    const bool is_usable = parameters && std::isfinite(parameters->a) && parameters->a > 0 &&
                           std::isfinite(parameters->b);
    if (!is_usable) return Fail("data: no parameters of the quantised inverse depths in front");
    return FromInverse(*stored, *parameters);
  }
  return DepthOfCounts(*stored, kMetresPerMillimetre);
}

}  // namespace sprout
