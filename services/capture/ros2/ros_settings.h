#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/core/pose.h"

namespace sprout::capture {

/// What a topic is for.
enum class RosRole { kLeft, kRight, kLeftInfo, kRightInfo, kPoints, kDepth, kDepthInfo, kTf };
inline constexpr std::array kAllRosRoles = {
    RosRole::kLeft,   RosRole::kRight, RosRole::kLeftInfo,  RosRole::kRightInfo,
    RosRole::kPoints, RosRole::kDepth, RosRole::kDepthInfo, RosRole::kTf};

/// Which topics a rig of ROS 2 has; empty: it has none.
struct RosSettings {
  std::string file;  ///< MCAP, see McapParts(); empty: live
  std::string left;  ///< images: raw, or JPEG and PNG where the name ends with "/compressed"
  std::string right;
  std::string left_info;
  std::string right_info;
  std::string points;      ///< of a lidar or a ToF camera
  std::string depth;       ///< range image of a ToF camera
  std::string depth_info;  ///< its camera
  std::string rig;         ///< rig file: then the images are raw, and no camera_info is read
  std::string tf;          ///< transforms; empty: TransformTopics() of the left images
  /// Where the range sensor stands in the left image's frame; nothing: the transforms say.
  std::optional<Pose> left_from_range;
  double max_spread_ms = 20;
  int bits = 0;    ///< of pictures of 16 bits, see EightBits
  int domain = 0;  ///< of the source, else of ROS_DOMAIN_ID

  /// Topics of a role: of the transforms usually several, of others one or none.
  std::vector<std::string> TopicsOf(RosRole role) const;

  /// Whether the range image is a rectified one, so that P of its CameraInfo describes it: it has
  /// that of the left or right images, or its topic's last name says so ("image_rect_raw").
  bool DepthIsRectified() const;
};

/// Whether the last name of a topic of images has a word: "image_rect_color" has "rect".
bool NameHas(std::string image, std::string_view word);
/// Whether it says that images are rectified.
inline bool SaysRectified(const std::string& image) { return NameHas(image, "rect"); }

/// Where transforms may be that belong to a topic: /tf_static and /tf, as they are and in each
/// namespace of the topic.
std::vector<std::string> TransformTopics(const std::string& topic);

/// Reads ros2:left=TOPIC&right=TOPIC... or mcap:FILE?left=TOPIC&right=TOPIC... . A camera_info that
/// is not named stands beside its images: "/stereo/left/camera_info".
/// @throws ConfigError naming what is missing or wrong.
RosSettings ParseRosSource(const std::string& source);

}  // namespace sprout::capture
