#ifndef SPROUT_COMMON_MESSAGES_JPEG_H_
#define SPROUT_COMMON_MESSAGES_JPEG_H_

#include <cstdint>
#include <opencv2/core/types.hpp>
#include <optional>
#include <span>

namespace sprout {

/// Size of the picture in a JPEG stream, read from its frame header without decoding anything;
/// nothing when the bytes are no JPEG stream from start to end marker (zeros may follow).
std::optional<cv::Size> JpegSize(std::span<const uint8_t> data);

}  // namespace sprout

#endif  // SPROUT_COMMON_MESSAGES_JPEG_H_
