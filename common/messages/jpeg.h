#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <string>

#include "common/core/result.h"

namespace sprout {

/// Most scans of a JPEG stream: baseline has one to three, progressive about ten. Each takes a pass
/// over the whole picture, even with few bytes.
inline constexpr size_t kMaxJpegScans = 32;

/// Most pixels for each byte of a JPEG stream. A Huffman code has at least one bit, and each of its
/// 8×8 blocks at least one code.
inline constexpr int64_t kMaxJpegPixelsPerByte = 8 * 64;

/// The picture in a JPEG stream.
///
/// @param size  that the picture must have; nothing: any up to kMaxSide and kMaxPixels. libjpeg's
///              own header is compared with it, and the bounds above are checked, before memory is
///              allocated or anything is decoded.
/// @returns 8UC1 for a grey stream, else 8UC3 (BGR); pixels as they are, ignoring EXIF: a rotated
/// image fits no calibration. Also an error when libjpeg would only warn: it fills damaged parts
/// with grey.
/// O(pixels × scans); a progressive stream takes 6 bytes of memory a pixel beside the picture.
Result<cv::Mat> DecodeJpeg(std::span<const uint8_t> data, std::optional<cv::Size> size);

/// Chroma resolution of a JPEG: may be reduced for a photograph, not for colours that show values.
enum class JpegColors { kHalf, kFull };

/// Quality of pictures for people.
inline constexpr int kPreviewQuality = 85;

/// A picture (8UC1 grey or 8UC3 BGR, not empty) as a baseline JPEG stream. The same picture gives
/// the same bytes. O(pixels), about 5 ms a megapixel in grey and 15 ms in full colours.
/// @param quality  1 to 100, as libjpeg has it.
/// @throws std::runtime_error when libjpeg refuses.
std::string WriteJpeg(const cv::Mat& picture, JpegColors colors, int quality = kPreviewQuality);

}  // namespace sprout
