#include "common/messages/preview.h"

#include <lcmtypes/bot_core/image_t.hpp>
#include <string>

#include "common/messages/jpeg.h"
#include "common/messages/message_type.h"

namespace sprout {

std::vector<uint8_t> EncodePreview(const FrameId& id, const cv::Mat& picture) {
  const std::string stream = WriteJpeg(picture, JpegColors::kFull);
  bot_core::image_t message;
  message.utime = id.utime;
  message.width = picture.cols;
  message.height = picture.rows;
  message.row_stride = 0;
  message.pixelformat = bot_core::image_t::PIXEL_FORMAT_MJPEG;
  message.size = static_cast<int32_t>(stream.size());
  message.data.assign(stream.begin(), stream.end());
  message.nmetadata = 0;
  std::vector<uint8_t> bytes(static_cast<size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

bool IsPreview(std::span<const uint8_t> bytes) {
  return FingerprintOf(bytes) == static_cast<uint64_t>(bot_core::image_t::getHash());
}

}  // namespace sprout
