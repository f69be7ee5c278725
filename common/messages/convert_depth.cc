#include <cmath>
#include <cstring>
#include <string>

#include "common/core/checks.h"
#include "common/messages/convert.h"

namespace sprout {
namespace {

Result<void> CheckPoint(const CloudPoint& point, int32_t index) {
  const cv::Point3f& p = point.position_m;
  if (std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z) && p.z > 0) return {};
  return Fail("point " + std::to_string(index) + " at (" + std::to_string(p.x) + ", " +
              std::to_string(p.y) + ", " + std::to_string(p.z) +
              "): allowed are finite numbers with z > 0");
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
  message.depth.reserve(2 * depth.counts.total());
  for (int v = 0; v < depth.counts.rows; ++v) {
    for (const uint16_t count : depth.counts.row(v)) {
      message.depth.push_back(static_cast<uint8_t>(count & 0xff));
      message.depth.push_back(static_cast<uint8_t>(count >> 8));
    }
  }
  message.size = static_cast<int32_t>(message.depth.size());
  return message;
}

Result<DepthImage> FromMessage(const depth_image_t& message) {
  const int64_t bytes = 2 * int64_t{message.width} * message.height;
  Checks checks;
  checks.Side("width", message.width)
      .Side("height", message.height)
      .Pixels("width × height", message.width, message.height)
      .Positive("focal_px", message.focal_px)
      .Finite("cx", message.cx)
      .Finite("cy", message.cy)
      .Positive("metres_per_count", message.metres_per_count)
      .Require(message.size == bytes && message.depth.size() == static_cast<size_t>(bytes), "size",
               message.size, "2 × width × height = " + std::to_string(bytes));
  if (!checks.ok()) return checks.error();
  DepthImage depth{.counts = cv::Mat1w(message.height, message.width),
                   .metres_per_count = message.metres_per_count,
                   .focal_px = message.focal_px,
                   .cx = message.cx,
                   .cy = message.cy};
  const uint8_t* next = message.depth.data();
  for (uint16_t& count : depth.counts) {
    count = static_cast<uint16_t>(next[0] | next[1] << 8);
    next += 2;
  }
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
  cloud.points.reserve(count);
  for (size_t i = 0; i < count; ++i) {
    cloud.points.push_back({.position_m = {message.x[i], message.y[i], message.z[i]},
                            .bgr = {message.blue[i], message.green[i], message.red[i]},
                            .confidence = message.confidence[i]});
    const Result<void> point = CheckPoint(cloud.points.back(), static_cast<int32_t>(i));
    if (!point) return tl::unexpected(point.error());
  }
  return cloud;
}

}  // namespace sprout
