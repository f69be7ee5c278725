#include "services/capture/genicam/pixels.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <vector>

#include "common/core/image.h"
#include "common/core/joined.h"

namespace sprout::capture {
namespace {

constexpr std::array kFormats = {
    PixelTraits{PixelFormat::kMono8, "Mono8", PixelKind::kGrey, CV_8UC1},
    PixelTraits{PixelFormat::kBayerRG8, "BayerRG8", PixelKind::kColour, CV_8UC1,
                cv::COLOR_BayerRGGB2BGR},
    PixelTraits{PixelFormat::kBayerGR8, "BayerGR8", PixelKind::kColour, CV_8UC1,
                cv::COLOR_BayerGRBG2BGR},
    PixelTraits{PixelFormat::kBayerGB8, "BayerGB8", PixelKind::kColour, CV_8UC1,
                cv::COLOR_BayerGBRG2BGR},
    PixelTraits{PixelFormat::kBayerBG8, "BayerBG8", PixelKind::kColour, CV_8UC1,
                cv::COLOR_BayerBGGR2BGR},
    PixelTraits{PixelFormat::kRGB8, "RGB8", PixelKind::kColour, CV_8UC3, cv::COLOR_RGB2BGR},
    PixelTraits{PixelFormat::kBGR8, "BGR8", PixelKind::kColour, CV_8UC3},
    PixelTraits{PixelFormat::kCoord3dC16, "Coord3D_C16", PixelKind::kCoordinates, CV_16UC1},
    PixelTraits{PixelFormat::kCoord3dC32f, "Coord3D_C32f", PixelKind::kCoordinates, CV_32FC1},
    PixelTraits{PixelFormat::kCoord3dAbc16, "Coord3D_ABC16", PixelKind::kCoordinates, CV_16UC3},
    PixelTraits{PixelFormat::kCoord3dAbc32f, "Coord3D_ABC32f", PixelKind::kCoordinates, CV_32FC3},
    PixelTraits{PixelFormat::kCoord3dAbcy16, "Coord3D_ABCY16", PixelKind::kCoordinates, CV_16UC4},
    PixelTraits{PixelFormat::kMono16, "Mono16", PixelKind::kGrey, CV_16UC1},
    PixelTraits{PixelFormat::kConfidence8, "Confidence8", PixelKind::kConfidence, CV_8UC1},
    PixelTraits{PixelFormat::kConfidence16, "Confidence16", PixelKind::kConfidence, CV_16UC1},
};

std::string NamesOf(bool (*is_one)(PixelFormat)) {
  std::vector<std::string_view> names;
  for (const PixelTraits& row : kFormats) {
    if (is_one(row.format)) names.push_back(row.name);
  }
  return Joined(", ", names);
}

}  // namespace

const PixelTraits* TraitsOf(uint32_t format) {
  const auto row =
      std::ranges::find(kFormats, static_cast<PixelFormat>(format), &PixelTraits::format);
  return row == kFormats.end() ? nullptr : &*row;
}

std::optional<PixelFormat> PixelFormatNamed(std::string_view name) {
  const auto row = std::ranges::find(kFormats, name, &PixelTraits::name);
  if (row == kFormats.end()) return std::nullopt;
  return row->format;
}

std::string PixelFormatName(uint32_t format) {
  const PixelTraits* row = TraitsOf(format);
  return row ? std::string(row->name) : fmt::format("0x{:08X}", format);
}

std::string StereoFormatNames() { return NamesOf(IsStereoFormat); }
std::string TofFormatNames() { return NamesOf(IsTofFormat); }

bool IsStereoFormat(PixelFormat format) {
  const PixelTraits* row = TraitsOf(static_cast<uint32_t>(format));
  return row && (row->kind == PixelKind::kColour || format == PixelFormat::kMono8);
}

bool IsTofFormat(PixelFormat format) {
  const PixelTraits* row = TraitsOf(static_cast<uint32_t>(format));
  return row && (row->kind == PixelKind::kCoordinates || format == PixelFormat::kMono16);
}

Result<size_t> RowBytes(const PayloadPart& part) {
  const PixelTraits* traits = TraitsOf(part.format);
  if (!traits) {
    return Fail(fmt::format("pixel format {} is not understood; allowed: {}; of a ToF camera: {}",
                            PixelFormatName(part.format), StereoFormatNames(), TofFormatNames()));
  }
  if (part.width < 1 || part.height < 1 || part.width > kMaxSide || part.height > kMaxSide ||
      int64_t{part.width} * part.height > kMaxPixels) {
    return Fail(fmt::format("an image of {}x{} pixels; allowed: 1 to {} a side", part.width,
                            part.height, kMaxSide));
  }
  const size_t row = static_cast<size_t>(part.width * CV_ELEM_SIZE(traits->type));
  const size_t stride = row + std::min(part.row_padding, part.bytes.size());
  // The last row may lack its padding.
  const size_t needed = stride * static_cast<size_t>(part.height - 1) + row;
  if (part.bytes.size() < needed) {
    return Fail(fmt::format("{} bytes for {}x{} pixels of {}; needed: {}", part.bytes.size(),
                            part.width, part.height, PixelFormatName(part.format), needed));
  }
  return stride;
}

Result<cv::Mat> ToImage(const PayloadPart& part) {
  const Result<size_t> stride = RowBytes(part);
  if (!stride) return Fail(stride.error().text);
  if (!IsStereoFormat(static_cast<PixelFormat>(part.format))) {
    return Fail("pixel format " + PixelFormatName(part.format) +
                " is not a stereo camera's; allowed: " + StereoFormatNames());
  }
  const PixelTraits& traits = *TraitsOf(part.format);
  // OpenCV has no view of bytes that are const; it is only read.
  const cv::Mat raw(part.height, part.width, traits.type, const_cast<uint8_t*>(part.bytes.data()),
                    *stride);
  if (!traits.to_bgr) return raw.clone();
  cv::Mat image;
  cv::cvtColor(raw, image, *traits.to_bgr);
  return image;
}

}  // namespace sprout::capture
