#include "common/messages/convert.h"

#include <algorithm>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <string>

#include "common/core/checks.h"
#include "common/messages/disparity_codec.h"
#include "common/messages/jpeg.h"
#include "common/messages/pose_fields.h"

namespace sprout {
namespace {

int BytesPerPixel(int32_t pixel_format) {
  switch (pixel_format) {
    case image_t::PIXEL_FORMAT_GREY:
      return 1;
    case image_t::PIXEL_FORMAT_RGB3:
    case image_t::PIXEL_FORMAT_BGR3:
      return 3;
    default:
      return 0;
  }
}

cv::Mat1f ToMat(const std::vector<float>& values, int height) {
  return cv::Mat1f(values).reshape(1, height).clone();
}

std::vector<float> ToVector(const cv::Mat1f& values) {
  if (values.empty()) return {};  // OpenCV divides by zero between the iterators of an empty matrix
  return {values.begin(), values.end()};
}

// Shares the memory. OpenCV's filters would look beyond the borders of a part, at what lies around
// it in the whole; so this one is whole for them.
cv::Mat PartOf(const cv::Mat1b& memory, std::span<const uint8_t> data) {
  const auto start = static_cast<int>(data.data() - memory.data);
  cv::Mat part = memory.colRange(start, start + static_cast<int>(data.size()));
  part.flags &= ~cv::Mat::SUBMATRIX_FLAG;
  part.datastart = part.data;
  part.dataend = part.datalimit = part.data + data.size();
  return part;
}

}  // namespace

header_t ToMessage(const FrameId& id) {
  header_t message;
  message.utime = id.utime;
  message.seq = id.seq;
  message.rig_id = id.rig_id;
  return message;
}

Result<FrameId> FromMessage(const header_t& message) {
  Checks checks;
  checks.NotNegative("header.utime", message.utime)
      .Require(message.seq >= -1, "header.seq", message.seq, ">= 0 (-1 in a status: no frame)")
      .Length("header.rig_id", message.rig_id, kMaxNameLength);
  if (!checks.ok()) return checks.error();
  return FrameId{.utime = message.utime, .seq = message.seq, .rig_id = message.rig_id};
}

image_t ToMessage(const FrameId& id, const cv::Mat& image) {
  CV_Assert(image.type() == CV_8UC1 || image.type() == CV_8UC3);
  image_t message;
  message.header = ToMessage(id);
  message.width = image.cols;
  message.height = image.rows;
  message.row_stride = image.cols * image.channels();
  message.pixel_format = image_t::PIXEL_FORMAT_GREY;
  if (image.channels() == 3) message.pixel_format = image_t::PIXEL_FORMAT_BGR3;
  message.data = BytesOf(image);
  message.size = static_cast<int32_t>(message.data.size());
  return message;
}

Result<cv::Mat> FromMessage(const image_t& message, std::span<const uint8_t> data,
                            const cv::Mat1b& memory) {
  const int bytes_per_pixel = BytesPerPixel(message.pixel_format);
  const bool jpeg = message.pixel_format == image_t::PIXEL_FORMAT_MJPG;
  Checks checks;
  checks.Side("width", message.width)
      .Side("height", message.height)
      .Pixels("width × height", message.width, message.height)
      .Require(jpeg || bytes_per_pixel > 0, "pixel_format", message.pixel_format,
               "GREY, RGB3, BGR3 or MJPG")
      .Require(message.size >= 0 && static_cast<size_t>(message.size) == data.size(), "size",
               message.size, "the number of bytes in data");
  if (!checks.ok()) return checks.error();
  if (jpeg) return DecodeJpeg(data, cv::Size(message.width, message.height));

  const int64_t bytes = int64_t{message.row_stride} * message.height;
  checks
      .Require(message.row_stride >= message.width * bytes_per_pixel, "row_stride",
               message.row_stride, "at least width × bytes per pixel")
      .Require(message.size == bytes, "size", message.size,
               "row_stride × height = " + std::to_string(bytes));
  if (!checks.ok()) return checks.error();
  const cv::Mat view(message.height, message.width, CV_8UC(bytes_per_pixel),
                     const_cast<uint8_t*>(data.data()), static_cast<size_t>(message.row_stride));
  cv::Mat image;
  if (message.pixel_format == image_t::PIXEL_FORMAT_RGB3) {
    cv::cvtColor(view, image, cv::COLOR_RGB2BGR);
  } else if (!memory.empty() && view.isContinuous()) {
    image = PartOf(memory, data).reshape(bytes_per_pixel, message.height);
  } else {
    image = view.clone();
  }
  return image;
}

tof_image_t ToMessage(const FrameId& id, const TofImage& tof) {
  tof_image_t message;
  message.header = ToMessage(id);
  message.width = tof.depth_m.cols;
  message.height = tof.depth_m.rows;
  message.depth_m = ToVector(tof.depth_m);
  message.amplitude = ToVector(tof.amplitude);
  message.count = static_cast<int32_t>(message.depth_m.size());
  message.amplitude_count = static_cast<int32_t>(message.amplitude.size());
  return message;
}

Result<TofImage> FromMessage(const tof_image_t& message) {
  const int64_t pixels = int64_t{message.width} * message.height;
  Checks checks;
  checks.SidesOrNone("width", message.width, "height", message.height)
      .Pixels("width × height", message.width, message.height)
      .Require(message.count == pixels && message.depth_m.size() == static_cast<size_t>(pixels),
               "count", message.count, "width × height = " + std::to_string(pixels))
      .Require(message.amplitude_count == 0 || message.amplitude_count == pixels, "amplitude_count",
               message.amplitude_count, "0 or width × height = " + std::to_string(pixels))
      .Require(message.amplitude.size() == static_cast<size_t>(message.amplitude_count),
               "amplitude_count", message.amplitude_count, "the number of amplitudes");
  if (!checks.ok()) return checks.error();
  TofImage tof;
  if (pixels == 0) return tof;
  tof.depth_m = ToMat(message.depth_m, message.height);
  std::replace_if(
      tof.depth_m.begin(), tof.depth_m.end(), [](float depth_m) { return !IsReturn(depth_m); },
      std::numeric_limits<float>::quiet_NaN());
  if (message.amplitude_count > 0) {
    tof.amplitude = ToMat(message.amplitude, message.height);
  }
  return tof;
}

rig_t ToMessage(const FrameId& id, const Rig& rig) {
  rig_t message;
  message.header = ToMessage(id);
  message.width = rig.pair.width;
  message.height = rig.pair.height;
  message.focal_px = rig.pair.focal_px;
  message.cx = rig.pair.cx;
  message.cy = rig.pair.cy;
  message.cx_right = rig.pair.cx_right;
  message.baseline_m = rig.pair.baseline_m;
  message.tof_width = rig.tof.width;
  message.tof_height = rig.tof.height;
  message.tof_fx = rig.tof.fx;
  message.tof_fy = rig.tof.fy;
  message.tof_cx = rig.tof.cx;
  message.tof_cy = rig.tof.cy;
  std::copy(rig.tof.distortion.begin(), rig.tof.distortion.end(), message.tof_distortion);
  FillPose({rig.tof.left_from_tof_rotation, rig.tof.left_from_tof_translation_m},
           message.left_from_tof_rotation, message.left_from_tof_translation_m);
  return message;
}

Result<Rig> FromMessage(const rig_t& message) {
  const Pose left_from_tof =
      PoseOf(message.left_from_tof_rotation, message.left_from_tof_translation_m);
  Rig rig{.pair = {.width = message.width,
                   .height = message.height,
                   .focal_px = message.focal_px,
                   .cx = message.cx,
                   .cy = message.cy,
                   .cx_right = message.cx_right,
                   .baseline_m = message.baseline_m},
          .tof = {.width = message.tof_width,
                  .height = message.tof_height,
                  .fx = message.tof_fx,
                  .fy = message.tof_fy,
                  .cx = message.tof_cx,
                  .cy = message.tof_cy,
                  .left_from_tof_rotation = left_from_tof.rotation,
                  .left_from_tof_translation_m = left_from_tof.translation_m}};
  std::copy(std::begin(message.tof_distortion), std::end(message.tof_distortion),
            rig.tof.distortion.begin());
  return CheckRig(rig).map([&] { return rig; });
}

disparity_image_t ToMessage(const FrameId& id, const DisparityImage& disparity,
                            DisparityEncoding encoding) {
  disparity_image_t message;
  message.header = ToMessage(id);
  message.width = disparity.width();
  message.height = disparity.height();
  message.counts_per_px = DisparityImage::kCountsPerPixel;
  message.invalid = DisparityImage::kInvalid;
  switch (encoding) {
    case DisparityEncoding::kRawInt16:
      message.encoding = disparity_image_t::ENCODING_RAW_INT16;
      message.data = BytesOf(disparity.counts());
      break;
    case DisparityEncoding::kDeltaZstd:
      message.encoding = disparity_image_t::ENCODING_DELTA_ZSTD;
      message.data = EncodeDeltaZstd(disparity);
      break;
  }
  message.size = static_cast<int32_t>(message.data.size());
  return message;
}

Result<DisparityImage> FromMessage(const disparity_image_t& message,
                                   std::span<const uint8_t> data) {
  Checks checks;
  checks.DisparityMap(message, data.size());
  if (!checks.ok()) return checks.error();
  const cv::Size size(message.width, message.height);
  switch (message.encoding) {
    case disparity_image_t::ENCODING_RAW_INT16:
      return DecodeRawInt16(data, size);
    case disparity_image_t::ENCODING_DELTA_ZSTD:
      return DecodeDeltaZstd(data, size);
    default:
      return Fail("encoding = " + std::to_string(message.encoding) +
                  ": allowed is RAW_INT16 or DELTA_ZSTD");
  }
}

}  // namespace sprout
