#include "common/ros/compressed.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <opencv2/imgcodecs.hpp>
#include <span>
#include <string>
#include <vector>

#include "common/messages/jpeg.h"

namespace sprout {
namespace {

RosMessage<RosCompressedImage> Compressed(const RosPlace& place, std::string_view format,
                                          size_t bytes) {
  RosMessage<RosCompressedImage> ros;
  ros->header.stamp = RosStamp(place.utime);
  SetRosText(ros->header.frame_id, place.frame);
  SetRosText(ros->format, format);
  ResizeRos(ros->data, bytes);
  return ros;
}

// In front of compressed_depth_image_transport's PNG: the format and two parameters of 32FC1.
struct DepthHeader {
  int32_t format = 1;  // INV_DEPTH, whatever the encoding
  std::array<float, 2> quantisation = {};
};

}  // namespace

RosMessage<RosCompressedImage> ToRosJpeg(const RosPlace& place, const cv::Mat& picture) {
  const std::string jpeg = WriteJpeg(picture, JpegColors::kHalf);
  const bool is_grey = picture.channels() == 1;
  auto ros = Compressed(place, is_grey ? "mono8; jpeg compressed " : "bgr8; jpeg compressed bgr8",
                        jpeg.size());
  std::ranges::copy(jpeg, RosSpan(ros->data).begin());
  return ros;
}

RosMessage<RosCompressedImage> ToRosCompressedDepth(const RosPlace& place,
                                                    const DepthImage& depth) {
  std::vector<uint8_t> png;
  // The strongest level would take a second for 2 MP.
  cv::imencode(".png", RosMillimetres(depth), png, {cv::IMWRITE_PNG_COMPRESSION, 1});
  auto ros = Compressed(place, "16UC1; compressedDepth png", sizeof(DepthHeader) + png.size());
  const std::span bytes = RosSpan(ros->data);
  const DepthHeader header;
  std::memcpy(bytes.data(), &header, sizeof header);
  std::ranges::copy(png, bytes.begin() + sizeof header);
  return ros;
}

}  // namespace sprout
