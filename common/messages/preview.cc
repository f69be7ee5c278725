#include "common/messages/preview.h"

#include <lcmtypes/bot_core/image_t.hpp>
#include <lcmtypes/bot_core/planar_lidar_t.hpp>
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
  return EncodeMessage(message);
}

bool IsPreview(std::span<const uint8_t> bytes) {
  return FingerprintOf(bytes) == static_cast<uint64_t>(bot_core::image_t::getHash());
}

std::vector<uint8_t> EncodeScan(const FrameId& id, const PlanarScan& scan) {
  bot_core::planar_lidar_t message;
  message.utime = id.utime;
  message.nranges = static_cast<int32_t>(scan.ranges_m.size());
  message.ranges = scan.ranges_m;
  message.nintensities = 0;
  message.rad0 = static_cast<float>(scan.first * scan.step_rad);
  message.radstep = static_cast<float>(scan.step_rad);
  return EncodeMessage(message);
}

bool IsScan(std::span<const uint8_t> bytes) {
  return FingerprintOf(bytes) == static_cast<uint64_t>(bot_core::planar_lidar_t::getHash());
}

}  // namespace sprout
