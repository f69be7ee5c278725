#pragma once

#include <cstdint>
#include <limits>
#include <opencv2/core.hpp>
#include <vector>

namespace sprout {

/// Depth z along the optical axis of the camera that sees it, the left one or a target (see
/// services/depth), with the intrinsics of this image.
struct DepthImage {
  cv::Mat1w counts;             ///< depth in units of metres_per_count; 0 = none
  double metres_per_count = 0;  ///< > 0
  double focal_px = 0;          ///< focal length, px
  double cx = 0;                ///< principal point, px
  double cy = 0;

  cv::Size size() const { return counts.size(); }
  double Metres(int u, int v) const { return counts(v, u) * metres_per_count; }
};

/// The largest count in a DepthImage of standard deviations: this much or more, or not known.
inline constexpr uint16_t kMaxDepthSigmaCounts = std::numeric_limits<uint16_t>::max();

/// Most points of a cloud: with 16 bytes each they fit into a message.
inline constexpr int kMaxCloudPoints = 12'000'000;

/// Point of a cloud.
struct CloudPoint {
  /// In the camera's frame (x right, y down, z forward), m; z > 0. Of Part::kBaseCloud in the
  /// robot's, with any z.
  cv::Point3f position_m;
  cv::Vec3b bgr;             ///< colour
  uint8_t confidence = 255;  ///< 255 · probability of an error <= 1 px

  bool operator==(const CloudPoint&) const = default;
};

/// Points of one frame.
struct PointCloud {
  std::vector<CloudPoint> points;

  bool operator==(const PointCloud&) const = default;
};

}  // namespace sprout
