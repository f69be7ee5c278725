#ifndef SPROUT_COMMON_ROS_ROS_ENVIRONMENT_H_
#define SPROUT_COMMON_ROS_ROS_ENVIRONMENT_H_

#include <cstdint>
#include <string>

namespace sprout {

/// The configuration of Cyclone DDS (XML) for a domain: what Sprout needs, behind it what ROS's
/// variables say of discovery, behind that CYCLONEDDS_URI. The last word counts.
/// @throws RosError for a value of a variable that cannot be.
std::string CycloneConfig(uint32_t max_message_bytes);

}  // namespace sprout

#endif  // SPROUT_COMMON_ROS_ROS_ENVIRONMENT_H_
