#ifndef SPROUT_SERVICES_CAPTURE_ROS2_ROS_SETTINGS_H_
#define SPROUT_SERVICES_CAPTURE_ROS2_ROS_SETTINGS_H_

#include <cstdint>
#include <string>
#include <vector>

namespace sprout::capture {

/// What a topic is for.
enum class RosRole { kLeft, kRight, kLeftInfo, kRightInfo, kPoints, kDepth, kDepthInfo, kTf };
inline constexpr size_t kRosRoles = static_cast<size_t>(RosRole::kTf) + 1;

/// Which topics a rig of ROS 2 has; empty: it has none.
struct RosSettings {
  std::string file;  ///< MCAP; empty: live
  std::string left;  ///< images: raw, or JPEG where the name ends with "/compressed"
  std::string right;
  std::string left_info;
  std::string right_info;
  std::string points;      ///< of a lidar or a ToF camera
  std::string depth;       ///< range image of a ToF camera
  std::string depth_info;  ///< its camera
  std::string rig;         ///< rig file: then the images are raw, and no camera_info is read
  double max_spread_ms = 20;
  int domain = 0;  ///< as ROS_DOMAIN_ID

  const std::string& TopicOf(RosRole role) const;
};

/// Whether a source is ros2: or mcap:.
bool NamesRos(const std::string& source);

/// Reads ros2:left=TOPIC&right=TOPIC... or mcap:FILE?left=TOPIC&right=TOPIC... . A camera_info that
/// is not named stands beside its images: "/stereo/left/camera_info".
/// @throws ConfigError naming what is missing or wrong.
RosSettings ParseRosSource(const std::string& source);

}  // namespace sprout::capture

#endif  // SPROUT_SERVICES_CAPTURE_ROS2_ROS_SETTINGS_H_
