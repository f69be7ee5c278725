#pragma once

#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "common/config/config.h"
#include "common/core/depth_counts.h"
#include "common/core/disparity_image.h"
#include "common/core/pose.h"
#include "common/core/rig.h"

namespace sprout::depth {

/// What is left out of a map; by default nothing.
struct FilterRules {
  double min_m = 0;  ///< depths below it; 0 = none
  double max_m = 0;  ///< depths above it; 0 = none
  /// Pixels outside: two opposite corners of a rectangle, or a polygon's, px; borders are inside.
  std::vector<cv::Point> region = {};
  /// Points outside the box in the robot's frame, m, and where that frame is.
  std::optional<Eigen::AlignedBox3d> box = {};
  Pose base_from_left = {};
  int min_confidence = 0;      ///< confidences below it
  bool remove_flying = false;  ///< see FindFlying()
};

/// Leaves pixels out of disparity maps, and counts them by rule. Keeps the region's mask, so one
/// object serves one caller at a time.
class MapFilter {
 public:
  explicit MapFilter(FilterRules rules);

  /// Whether every rule is off.
  bool IsOff() const;

  /// The map without the pixels that a rule leaves out. O(pixels).
  /// @param pair        of the map's size.
  /// @param confidence  8UC1 of the map's size; empty when min_confidence is 0.
  DisparityImage Apply(const DisparityImage& map, const RectifiedPair& pair,
                       const cv::Mat& confidence, DepthCounts& counts);

  /// Whether there is a region, and no pixel of such a map lies in it.
  bool RegionIsOutside(cv::Size size);

 private:
  void DrawRegion(cv::Size size);

  FilterRules rules_;
  cv::Mat1b inside_;  // the region; empty without one
  bool is_outside_ = false;
};

/// What the configuration leaves out of maps.
/// @param base_from_left  of the rig file; nothing without one, and then there can be no box.
/// @throws ConfigError for what does not go together.
FilterRules FilterOf(const DepthConfig& config, const std::optional<Pose>& base_from_left);

/// Whether points outside a box of the robot's frame are left out.
bool HasBox(const DepthConfig& config);

/// @throws ConfigError unless low < high; names are those of DepthConfig.
void RequireOrder(const char* low_name, double low, const char* high_name, double high);

}  // namespace sprout::depth
