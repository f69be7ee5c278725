#include "services/capture/genicam/scan3d.h"

#include <fmt/core.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>

namespace sprout::capture {
namespace {

static_assert(std::endian::native == std::endian::little, "payloads are little endian");

// Channels of a pixel with A, B, C and perhaps the intensity.
constexpr int kCoordinateC = 2;
constexpr int kIntensity = 3;

// One channel of every pixel: `wanted`, else the only one or coordinate C. Refuses formats of
// colour, since a device may declare any image to be one of ranges.
Result<cv::Mat1d> ReadPart(const PayloadPart& part, std::optional<int> wanted = {}) {
  const Result<size_t> stride = RowBytes(part);
  if (!stride) return Fail(stride.error().text);
  const PixelTraits& traits = *TraitsOf(part.format);
  if (traits.kind == PixelKind::kColour) {
    return Fail("pixel format " + PixelFormatName(part.format) +
                " holds no ranges and no confidence; allowed: " + TofFormatNames());
  }
  cv::Mat pixels(part.height, part.width, traits.type);  // rows of a payload begin anywhere
  for (int v = 0; v < part.height; ++v) {
    const uint8_t* row = part.bytes.data() + static_cast<size_t>(v) * *stride;
    std::copy_n(row, pixels.step[0], pixels.ptr(v));
  }
  cv::Mat plane;
  cv::extractChannel(pixels, plane, wanted.value_or(pixels.channels() == 1 ? 0 : kCoordinateC));
  cv::Mat1d values;
  plane.convertTo(values, CV_64F);
  return values;
}

bool IsOfKind(const PayloadPart& part, PixelKind kind) {
  const PixelTraits* traits = TraitsOf(part.format);
  return traits && traits->kind == kind;
}

bool IsCoordinate(const PayloadPart& part) {
  return part.content == PartContent::kRange || IsOfKind(part, PixelKind::kCoordinates);
}

bool IsConfidence(const PayloadPart& part) {
  return part.content == PartContent::kConfidence || IsOfKind(part, PixelKind::kConfidence);
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
    if (role || (&role == &roles.amplitude && !IsOfKind(part, PixelKind::kGrey))) continue;
    role = &part;
  }
  // A camera without formats of coordinates sends ranges as grey levels.
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
  const bool is_count = CV_MAT_DEPTH(TraitsOf(roles.range->format)->type) != CV_32F;
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
