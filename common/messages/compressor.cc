#include "common/messages/compressor.h"

#include <string>
#include <utility>

#include "common/core/frame.h"
#include "common/messages/codec.h"
#include "common/messages/jpeg.h"
#include "common/messages/message_type.h"

namespace sprout {
namespace {

// Whether a message is a camera's image. Other images are maps, whose numbers JPEG would change.
bool IsCameraImage(std::string_view channel, std::span<const uint8_t> message) {
  return TypeOf(message) == MessageType::kImage &&
         (channel.ends_with(ChannelOf(Part::kLeft)) || channel.ends_with(ChannelOf(Part::kRight)));
}

// Nothing when it is JPEG already, or cannot be decoded.
std::optional<std::vector<uint8_t>> JpegOf(std::span<const uint8_t> message, int quality) {
  const Result<DecodedPart> decoded = DecodePart(Part::kLeft, message);
  if (!decoded) return std::nullopt;
  const auto& picture = std::get<cv::Mat>(decoded->value);
  const std::string stream = WriteJpeg(picture, JpegColors::kHalf, quality);
  if (stream.size() >= message.size()) return std::nullopt;
  image_t jpeg;
  jpeg.header = ToMessage(decoded->id);
  jpeg.width = picture.cols;
  jpeg.height = picture.rows;
  jpeg.row_stride = 0;
  jpeg.pixel_format = image_t::PIXEL_FORMAT_MJPG;
  jpeg.size = static_cast<int32_t>(stream.size());
  jpeg.data.assign(stream.begin(), stream.end());
  std::vector<uint8_t> bytes(static_cast<size_t>(jpeg.getEncodedSize()));
  jpeg.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

}  // namespace

std::optional<std::vector<uint8_t>> MessageCompressor::Compress(std::string_view channel,
                                                                std::span<const uint8_t> message) {
  if (!jpeg_quality_ || !IsCameraImage(channel, message)) return packer_.Pack(message);
  return JpegOf(message, *jpeg_quality_);
}

}  // namespace sprout
