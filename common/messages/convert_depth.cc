#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <string>
#include <utility>

#include "common/core/check_lens.h"
#include "common/core/checks.h"
#include "common/messages/convert.h"
#include "common/messages/disparity_codec.h"
#include "common/messages/pose_fields.h"

namespace sprout {
namespace {

static_assert(std::endian::native == std::endian::little,
              "counts are little-endian on the wire and are copied as they are");

bool IsPossible(const cv::Point3f& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

tl::unexpected<Error> NoPoint(const cv::Point3f& p, size_t index, const char* allowed) {
  return Fail("point " + std::to_string(index) + " at (" + std::to_string(p.x) + ", " +
              std::to_string(p.y) + ", " + std::to_string(p.z) + "): allowed are " + allowed);
}

}  // namespace

depth_image_t ToMessage(const FrameId& id, const DepthImage& depth) {
  depth_image_t message;
  message.header = ToMessage(id);
  message.width = depth.counts.cols;
  message.height = depth.counts.rows;
  message.focal_px = depth.focal_px;
  message.cx = depth.cx;
  message.cy = depth.cy;
  message.metres_per_count = depth.metres_per_count;
  message.depth = BytesOf(depth.counts);
  message.size = static_cast<int32_t>(message.depth.size());
  return message;
}

Result<DepthImage> FromMessage(const depth_image_t& message, std::span<const uint8_t> data) {
  const int64_t bytes = 2 * int64_t{message.width} * message.height;
  Checks checks;
  checks.Side("width", message.width)
      .Side("height", message.height)
      .Pixels("width × height", message.width, message.height)
      .Positive("focal_px", message.focal_px)
      .Finite("cx", message.cx)
      .Finite("cy", message.cy)
      .Positive("metres_per_count", message.metres_per_count)
      .Require(message.size == bytes && data.size() == static_cast<size_t>(bytes), "size",
               message.size, "2 × width × height = " + std::to_string(bytes));
  if (!checks.ok()) return checks.error();
  DepthImage depth{.counts = cv::Mat1w(message.height, message.width),
                   .metres_per_count = message.metres_per_count,
                   .focal_px = message.focal_px,
                   .cx = message.cx,
                   .cy = message.cy};
  std::memcpy(depth.counts.data, data.data(), data.size());  // a new image has no gaps
  return depth;
}

point_cloud_t ToMessage(const FrameId& id, const PointCloud& cloud) {
  point_cloud_t message;
  message.header = ToMessage(id);
  const size_t count = cloud.points.size();
  message.count = static_cast<int32_t>(count);
  for (auto* values : {&message.x, &message.y, &message.z}) values->resize(count);
  for (auto* values : {&message.red, &message.green, &message.blue, &message.confidence}) {
    values->resize(count);
  }
  for (size_t i = 0; i < count; ++i) {
    const CloudPoint& point = cloud.points[i];
    message.x[i] = point.position_m.x;
    message.y[i] = point.position_m.y;
    message.z[i] = point.position_m.z;
    message.blue[i] = point.bgr[0];
    message.green[i] = point.bgr[1];
    message.red[i] = point.bgr[2];
    message.confidence[i] = point.confidence;
  }
  return message;
}

Result<PointCloud> FromMessage(const point_cloud_t& message) {
  Checks checks;
  checks.Require(message.count >= 0 && message.count <= kMaxCloudPoints, "count", message.count,
                 "0 to " + std::to_string(kMaxCloudPoints));
  const auto count = static_cast<size_t>(message.count);
  for (const auto* values : {&message.x, &message.y, &message.z}) {
    checks.Require(values->size() == count, "count", message.count, "the number of coordinates");
  }
  for (const auto* values : {&message.red, &message.green, &message.blue, &message.confidence}) {
    checks.Require(values->size() == count, "count", message.count, "the number of colours");
  }
  if (!checks.ok()) return checks.error();
  PointCloud cloud;
  cloud.points.resize(count);
  for (size_t i = 0; i < count; ++i) {
    const cv::Point3f position(message.x[i], message.y[i], message.z[i]);
    if (!IsPossible(position)) return NoPoint(position, i, "finite numbers");
    cloud.points[i] = {.position_m = position,
                       .bgr = {message.blue[i], message.green[i], message.red[i]},
                       .confidence = message.confidence[i]};
  }
  return cloud;
}

Result<void> CheckInFront(const PointCloud& cloud) {
  for (size_t i = 0; i < cloud.points.size(); ++i) {
    const cv::Point3f& position = cloud.points[i].position_m;
    if (!(position.z > 0)) return NoPoint(position, i, "finite numbers with z > 0");
  }
  return {};
}

depth_counts_t ToMessage(const FrameId& id, const DepthCounts& counts) {
  depth_counts_t message;
  message.header = ToMessage(id);
  message.pixels = counts.pixels;
  message.near = counts.near;
  message.far = counts.far;
  message.outside = counts.outside;
  message.unsure = counts.unsure;
  message.flying = counts.flying;
  return message;
}

Result<DepthCounts> FromMessage(const depth_counts_t& message) {
  const DepthCounts counts{.pixels = message.pixels,
                           .near = message.near,
                           .far = message.far,
                           .outside = message.outside,
                           .unsure = message.unsure,
                           .flying = message.flying};
  Checks checks;
  int64_t left_out = 0;
  for (const auto& [field, count] : {std::pair("near", counts.near),
                                     {"far", counts.far},
                                     {"outside", counts.outside},
                                     {"unsure", counts.unsure},
                                     {"flying", counts.flying}}) {
    checks.NotNegative(field, count);
    left_out += count;
  }
  checks.Require(counts.pixels >= left_out, "pixels", counts.pixels,
                 "at least the pixels left out, " + std::to_string(left_out));
  if (!checks.ok()) return checks.error();
  return counts;
}

motion_t ToMessage(const FrameId& id, const CameraMotion& motion) {
  motion_t message;
  message.header = ToMessage(id);
  message.last_seq = motion.last_seq;
  message.start_seq = motion.start_seq;
  message.resets = motion.resets;
  message.tracked = motion.tracked;
  message.inliers = motion.inliers;
  message.reset = static_cast<int32_t>(motion.reset);
  FillPose(motion.last_from_left, message.last_from_left_rotation,
           message.last_from_left_translation_m);
  FillPose(motion.start_from_left, message.start_from_left_rotation,
           message.start_from_left_translation_m);
  std::copy(motion.covariance.begin(), motion.covariance.end(), message.covariance);
  return message;
}

Result<CameraMotion> FromMessage(const motion_t& message) {
  CameraMotion motion{.last_from_left = PoseOf(message.last_from_left_rotation,
                                               message.last_from_left_translation_m),
                      .start_from_left = PoseOf(message.start_from_left_rotation,
                                                message.start_from_left_translation_m),
                      .last_seq = message.last_seq,
                      .start_seq = message.start_seq,
                      .tracked = message.tracked,
                      .inliers = message.inliers,
                      .reset = MemoryReset::kNone,
                      .resets = message.resets};
  Checks checks;
  checks.NotNegative("last_seq", message.last_seq)
      .NotNegative("start_seq", message.start_seq)
      .NotNegative("resets", message.resets)
      .NotNegative("tracked", message.tracked)
      .Require(message.inliers >= 0 && message.inliers <= message.tracked, "inliers",
               message.inliers, "0 to tracked")
      .Require(message.reset >= 0 && message.reset < kMemoryResets, "reset", message.reset,
               "one of the RESET constants");
  CheckPoseFields(checks, "last_from_left", motion.last_from_left);
  CheckPoseFields(checks, "start_from_left", motion.start_from_left);
  for (const double value : message.covariance) checks.Finite("covariance", value);
  if (!checks.ok()) return checks.error();
  motion.reset = static_cast<MemoryReset>(message.reset);
  std::copy_n(message.covariance, motion.covariance.size(), motion.covariance.begin());
  return motion;
}

}  // namespace sprout
