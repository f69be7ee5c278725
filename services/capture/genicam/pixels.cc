#include "services/capture/genicam/pixels.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <opencv2/imgproc.hpp>

#include "common/core/image.h"

namespace sprout::capture {
namespace {

enum class Use { kStereo, kTof, kTofExtra };

struct FormatRow {
  PixelFormat format;
  std::string_view name;
  Use use;
};

constexpr std::array kFormats = {
    FormatRow{PixelFormat::kMono8, "Mono8", Use::kStereo},
    FormatRow{PixelFormat::kBayerRG8, "BayerRG8", Use::kStereo},
    FormatRow{PixelFormat::kBayerGR8, "BayerGR8", Use::kStereo},
    FormatRow{PixelFormat::kBayerGB8, "BayerGB8", Use::kStereo},
    FormatRow{PixelFormat::kBayerBG8, "BayerBG8", Use::kStereo},
    FormatRow{PixelFormat::kRGB8, "RGB8", Use::kStereo},
    FormatRow{PixelFormat::kBGR8, "BGR8", Use::kStereo},
    FormatRow{PixelFormat::kCoord3dC16, "Coord3D_C16", Use::kTof},
    FormatRow{PixelFormat::kCoord3dC32f, "Coord3D_C32f", Use::kTof},
    FormatRow{PixelFormat::kCoord3dAbc16, "Coord3D_ABC16", Use::kTof},
    FormatRow{PixelFormat::kCoord3dAbc32f, "Coord3D_ABC32f", Use::kTof},
    FormatRow{PixelFormat::kCoord3dAbcy16, "Coord3D_ABCY16", Use::kTof},
    FormatRow{PixelFormat::kMono16, "Mono16", Use::kTof},
    FormatRow{PixelFormat::kConfidence8, "Confidence8", Use::kTofExtra},
    FormatRow{PixelFormat::kConfidence16, "Confidence16", Use::kTofExtra},
};

const FormatRow* Find(uint32_t format) {
  const auto row =
      std::ranges::find(kFormats, static_cast<PixelFormat>(format), &FormatRow::format);
  return row == kFormats.end() ? nullptr : &*row;
}

std::string NamesOf(Use use) {
  std::string names;
  for (const FormatRow& row : kFormats) {
    if (row.use != use) continue;
    names += (names.empty() ? "" : ", ") + std::string(row.name);
  }
  return names;
}

// The second byte of a format's number is its bits a pixel.
size_t BytesPerPixel(uint32_t format) { return ((format >> 16) & 0xFF) / 8; }

std::optional<cv::ColorConversionCodes> ToBgrCode(PixelFormat format) {
  switch (format) {
    case PixelFormat::kBayerRG8:
      return cv::COLOR_BayerRGGB2BGR;
    case PixelFormat::kBayerGR8:
      return cv::COLOR_BayerGRBG2BGR;
    case PixelFormat::kBayerGB8:
      return cv::COLOR_BayerGBRG2BGR;
    case PixelFormat::kBayerBG8:
      return cv::COLOR_BayerBGGR2BGR;
    default:
      return std::nullopt;
  }
}

}  // namespace

std::optional<PixelFormat> PixelFormatNamed(std::string_view name) {
  const auto row = std::ranges::find(kFormats, name, &FormatRow::name);
  if (row == kFormats.end()) return std::nullopt;
  return row->format;
}

std::string PixelFormatName(uint32_t format) {
  const FormatRow* row = Find(format);
  return row ? std::string(row->name) : fmt::format("0x{:08X}", format);
}

std::string StereoFormatNames() { return NamesOf(Use::kStereo); }
std::string TofFormatNames() { return NamesOf(Use::kTof); }

bool IsStereoFormat(PixelFormat format) {
  const FormatRow* row = Find(static_cast<uint32_t>(format));
  return row && row->use == Use::kStereo;
}

bool IsTofFormat(PixelFormat format) {
  const FormatRow* row = Find(static_cast<uint32_t>(format));
  return row && row->use == Use::kTof;
}

Result<size_t> RowBytes(const PayloadPart& part) {
  if (!Find(part.format)) {
    return Fail(fmt::format("pixel format {} is not understood; allowed: {}; of a ToF camera: {}",
                            PixelFormatName(part.format), StereoFormatNames(), TofFormatNames()));
  }
  if (part.width < 1 || part.height < 1 || part.width > kMaxSide || part.height > kMaxSide ||
      int64_t{part.width} * part.height > kMaxPixels) {
    return Fail(fmt::format("an image of {}x{} pixels; allowed: 1 to {} a side", part.width,
                            part.height, kMaxSide));
  }
  const size_t row = static_cast<size_t>(part.width) * BytesPerPixel(part.format);
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
  const auto format = static_cast<PixelFormat>(part.format);
  if (!IsStereoFormat(format)) {
    return Fail("pixel format " + PixelFormatName(part.format) +
                " is not a stereo camera's; allowed: " + StereoFormatNames());
  }
  const bool is_colour = format == PixelFormat::kRGB8 || format == PixelFormat::kBGR8;
  // OpenCV has no view of bytes that are const; it is only read.
  const cv::Mat raw(part.height, part.width, is_colour ? CV_8UC3 : CV_8UC1,
                    const_cast<uint8_t*>(part.bytes.data()), *stride);
  cv::Mat image;
  if (const auto code = ToBgrCode(format)) {
    cv::demosaicing(raw, image, *code);
  } else if (format == PixelFormat::kRGB8) {
    cv::cvtColor(raw, image, cv::COLOR_RGB2BGR);
  } else {
    image = raw.clone();
  }
  return image;
}

}  // namespace sprout::capture
