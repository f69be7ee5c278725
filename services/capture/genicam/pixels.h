#ifndef SPROUT_SERVICES_CAPTURE_GENICAM_PIXELS_H_
#define SPROUT_SERVICES_CAPTURE_GENICAM_PIXELS_H_

#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "common/core/result.h"

namespace sprout::capture {

/// Pixel formats that are understood, by the numbers that GenICam's Pixel Format Naming Convention,
/// or the maker, gives them; 16-bit ones are little endian.
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

/// The format of GenICam's name ("BayerRG8"), if it is understood.
std::optional<PixelFormat> PixelFormatNamed(std::string_view name);

/// GenICam's name of a format; its number when it is not understood.
std::string PixelFormatName(uint32_t format);

/// Names of the formats that a camera of this kind may have, for messages: "Mono8, BayerRG8, …".
std::string StereoFormatNames();
std::string TofFormatNames();

/// Whether a camera of the pair, or a ToF camera, may have this format.
bool IsStereoFormat(PixelFormat format);
bool IsTofFormat(PixelFormat format);

/// What a part of a payload shows. A payload of one part does not say it: kUnknown.
enum class PartContent { kUnknown, kImage, kRange, kConfidence };

/// One image as it lies in a device's payload.
struct PayloadPart {
  uint32_t format = 0;     ///< a PixelFormat, or one that is not understood
  int width = 0;           ///< px
  int height = 0;          ///< px
  size_t row_padding = 0;  ///< bytes behind every row
  std::span<const uint8_t> bytes;
  PartContent content = PartContent::kUnknown;
};

/// Bytes from one row to the next, once the size was looked at: the error names a format that is
/// not understood, a size that cannot be, or bytes that are missing.
Result<size_t> RowBytes(const PayloadPart& part);

/// An image of the left or right camera, 8UC1, or 8UC3 (BGR) of a colour camera: Bayer patterns are
/// interpolated bilinearly (cv::demosaicing). A copy: the payload may go. O(pixels).
Result<cv::Mat> ToImage(const PayloadPart& part);

}  // namespace sprout::capture

#endif  // SPROUT_SERVICES_CAPTURE_GENICAM_PIXELS_H_
