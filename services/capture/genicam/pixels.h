#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "common/core/result.h"

namespace sprout::capture {

/// Supported pixel formats, with the numbers of GenICam's Pixel Format Naming Convention or of the
/// manufacturer; 16-bit ones are little endian.
enum class PixelFormat : uint32_t {
  kMono8 = 0x01080001,
  kMono16 = 0x01100007,
  kBayerGR8 = 0x01080008,
  kBayerRG8 = 0x01080009,
  kBayerGB8 = 0x0108000A,
  kBayerBG8 = 0x0108000B,
  kRGB8 = 0x02180014,
  kBGR8 = 0x02180015,
  kCoord3dAbc16 = 0x023000B9,
  kCoord3dAbc32f = 0x026000C0,
  kCoord3dC16 = 0x011000B8,
  kCoord3dC32f = 0x012000BF,
  kConfidence8 = 0x010800C6,
  kConfidence16 = 0x011000C7,
  kCoord3dAbcy16 = 0x82400403,  // Lucid's own: A, B, C and the intensity
};

/// What the numbers of a format are.
enum class PixelKind { kGrey, kColour, kCoordinates, kConfidence };

/// A supported format.
struct PixelTraits {
  PixelFormat format;
  std::string_view name;  ///< GenICam's
  PixelKind kind;
  int type;  ///< OpenCV's, of the pixels as they are sent
  std::optional<cv::ColorConversionCodes> to_bgr = {};  ///< of a colour that is not BGR
};

/// Null if the format is not supported.
const PixelTraits* TraitsOf(uint32_t format);

/// The format with this GenICam name ("BayerRG8"), if supported.
std::optional<PixelFormat> PixelFormatNamed(std::string_view name);

/// GenICam's name of a format; its number if not supported.
std::string PixelFormatName(uint32_t format);

/// Names of the formats that a camera of this kind may have, for messages: "Mono8, BayerRG8, …".
std::string StereoFormatNames();
std::string TofFormatNames();

/// Whether a camera of the pair, or a ToF camera, may have this format.
bool IsStereoFormat(PixelFormat format);
bool IsTofFormat(PixelFormat format);

/// The content of a part of a payload. A payload of one part does not say: kUnknown.
enum class PartContent { kUnknown, kImage, kRange, kConfidence };

/// One image in a device's payload.
struct PayloadPart {
  uint32_t format = 0;     ///< a PixelFormat, or an unsupported one
  int width = 0;           ///< px
  int height = 0;          ///< px
  size_t row_padding = 0;  ///< bytes after every row
  std::span<const uint8_t> bytes;
  PartContent content = PartContent::kUnknown;
};

/// Checks the size and returns the bytes from one row to the next. The error names an unsupported
/// format, an impossible size, or missing bytes.
Result<size_t> RowBytes(const PayloadPart& part);

/// An image of the left or right camera, 8UC1, or 8UC3 (BGR) of a colour camera: Bayer patterns are
/// interpolated bilinearly. A copy, independent of the payload. O(pixels).
Result<cv::Mat> ToImage(const PayloadPart& part);

}  // namespace sprout::capture
