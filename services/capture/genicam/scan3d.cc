#include "services/capture/genicam/scan3d.h"

#include <fmt/core.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>
#include <limits>

namespace sprout::capture {
namespace {

static_assert(std::endian::native == std::endian::little, "payloads are little endian");

// Which of a pixel's numbers is wanted: coordinate C is behind A and B.
struct Numbers {
  bool is_float = false;
  int count = 1;
  int wanted = 0;
  size_t bytes = 2;
};

constexpr int kIntensity = 3;  // of A, B, C, Y

// Nothing for formats of colour: a device may say of any image that it shows ranges.
std::optional<Numbers> NumbersOf(PixelFormat format) {
  switch (format) {
    case PixelFormat::kCoord3dAbc16:
      return Numbers{.is_float = false, .count = 3, .wanted = 2, .bytes = 2};
    case PixelFormat::kCoord3dAbcy16:
      return Numbers{.is_float = false, .count = 4, .wanted = 2, .bytes = 2};
    case PixelFormat::kCoord3dAbc32f:
      return Numbers{.is_float = true, .count = 3, .wanted = 2, .bytes = 4};
    case PixelFormat::kCoord3dC32f:
      return Numbers{.is_float = true, .count = 1, .wanted = 0, .bytes = 4};
    case PixelFormat::kMono8:
    case PixelFormat::kConfidence8:
      return Numbers{.is_float = false, .count = 1, .wanted = 0, .bytes = 1};
    case PixelFormat::kCoord3dC16:
    case PixelFormat::kMono16:
    case PixelFormat::kConfidence16:
      return Numbers{};
    default:
      return std::nullopt;
  }
}

double ReadNumber(const uint8_t* bytes, const Numbers& numbers) {
  if (numbers.is_float) {
    float value = 0;
    std::memcpy(&value, bytes, sizeof value);
    return static_cast<double>(value);
  }
  if (numbers.bytes == 1) return *bytes;
  uint16_t value = 0;
  std::memcpy(&value, bytes, sizeof value);
  return value;
}

// One number of every pixel: the wanted one, or else that which was asked for.
Result<cv::Mat1d> ReadPart(const PayloadPart& part, std::optional<int> wanted = {}) {
  const Result<size_t> stride = RowBytes(part);
  if (!stride) return Fail(stride.error().text);
  std::optional<Numbers> numbers = NumbersOf(static_cast<PixelFormat>(part.format));
  if (!numbers) {
    return Fail("pixel format " + PixelFormatName(part.format) +
                " holds no ranges and no confidence; allowed: " + TofFormatNames());
  }
  numbers->wanted = wanted.value_or(numbers->wanted);
  const size_t pixel = numbers->bytes * static_cast<size_t>(numbers->count);
  cv::Mat1d values(part.height, part.width);
  for (int v = 0; v < part.height; ++v) {
    const uint8_t* bytes = part.bytes.data() + static_cast<size_t>(v) * *stride +
                           numbers->bytes * static_cast<size_t>(numbers->wanted);
    for (int u = 0; u < part.width; ++u, bytes += pixel) values(v, u) = ReadNumber(bytes, *numbers);
  }
  return values;
}

bool IsCoordinate(const PayloadPart& part) {
  switch (static_cast<PixelFormat>(part.format)) {
    case PixelFormat::kCoord3dC16:
    case PixelFormat::kCoord3dC32f:
    case PixelFormat::kCoord3dAbc16:
    case PixelFormat::kCoord3dAbc32f:
    case PixelFormat::kCoord3dAbcy16:
      return true;
    default:
      return part.content == PartContent::kRange;
  }
}

bool IsConfidence(const PayloadPart& part) {
  const auto format = static_cast<PixelFormat>(part.format);
  return part.content == PartContent::kConfidence || format == PixelFormat::kConfidence8 ||
         format == PixelFormat::kConfidence16;
}

bool IsAmplitude(const PayloadPart& part) {
  const auto format = static_cast<PixelFormat>(part.format);
  return format == PixelFormat::kMono16 || format == PixelFormat::kMono8;
}

struct Roles {
  const PayloadPart* range = nullptr;
  const PayloadPart* confidence = nullptr;
  const PayloadPart* amplitude = nullptr;
};

Roles RolesOf(std::span<const PayloadPart> parts) {
  Roles roles;
  for (const PayloadPart& part : parts) {
    const PayloadPart*& role = IsCoordinate(part)   ? roles.range
                               : IsConfidence(part) ? roles.confidence
                                                    : roles.amplitude;
    if (role || (&role == &roles.amplitude && !IsAmplitude(part))) continue;
    role = &part;
  }
  // Ranges from a camera that does not know of coordinates.
  if (!roles.range && roles.amplitude && roles.amplitude->content == PartContent::kUnknown &&
      roles.amplitude->format == static_cast<uint32_t>(PixelFormat::kMono16)) {
    std::swap(roles.range, roles.amplitude);
  }
  return roles;
}

Result<void> CheckSize(const PayloadPart* part, const PayloadPart& range) {
  if (!part || (part->width == range.width && part->height == range.height)) return {};
  return Fail(fmt::format("{} is {}x{}, {} is {}x{}; allowed: one size",
                          PixelFormatName(part->format), part->width, part->height,
                          PixelFormatName(range.format), range.width, range.height));
}

// 65535 is the largest of 16 bits: no return, or a saturated one (as DepthOfCounts() has it).
float MetresOf(double number, bool is_count, const Scan3d& scan3d) {
  if (!std::isfinite(number) || (scan3d.invalid && number == *scan3d.invalid)) return 0;
  if (is_count && number == std::numeric_limits<uint16_t>::max()) return 0;
  const auto metres = static_cast<float>((number * scan3d.scale + scan3d.offset) * scan3d.unit_m);
  return IsReturn(metres) ? metres : 0;
}

}  // namespace

Result<TofImage> ToTofImage(std::span<const PayloadPart> parts, const Scan3d& scan3d) {
  const Roles roles = RolesOf(parts);
  if (!roles.range) {
    std::string formats;
    for (const PayloadPart& part : parts) formats += " " + PixelFormatName(part.format);
    return Fail("no range in the payload's" + formats + "; allowed: " + TofFormatNames());
  }
  for (const PayloadPart* part : {roles.confidence, roles.amplitude}) {
    if (const Result<void> fits = CheckSize(part, *roles.range); !fits) {
      return Fail(fits.error().text);
    }
  }
  const Result<cv::Mat1d> numbers = ReadPart(*roles.range);
  if (!numbers) return Fail(numbers.error().text);
  TofImage image;
  image.depth_m.create(numbers->size());
  const bool is_count = !NumbersOf(static_cast<PixelFormat>(roles.range->format))->is_float;
  std::transform(numbers->begin(), numbers->end(), image.depth_m.begin(),
                 [&](double number) { return MetresOf(number, is_count, scan3d); });
  if (roles.confidence) {
    const Result<cv::Mat1d> confidence = ReadPart(*roles.confidence);
    if (!confidence) return Fail(confidence.error().text);
    image.depth_m.setTo(0, *confidence == 0);
    confidence->convertTo(image.amplitude, CV_32F);
  }
  if (roles.range->format == static_cast<uint32_t>(PixelFormat::kCoord3dAbcy16)) {
    ReadPart(*roles.range, kIntensity)->convertTo(image.amplitude, CV_32F);
  }
  if (roles.amplitude) {
    const Result<cv::Mat1d> amplitude = ReadPart(*roles.amplitude);
    if (!amplitude) return Fail(amplitude.error().text);
    amplitude->convertTo(image.amplitude, CV_32F);
  }
  return image;
}

void RangesToDepths(TofImage& image, const cv::Mat1d& range_per_depth) {
  assert(image.depth_m.size() == range_per_depth.size());
  cv::divide(image.depth_m, range_per_depth, image.depth_m, 1, CV_32F);
}

}  // namespace sprout::capture
