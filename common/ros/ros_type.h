#pragma once

#include <dds/ddsc/dds_public_impl.h>

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "messages.h"  // idlc's, of messages.idl

namespace sprout {

/// A message type of ROS 2.
struct RosType {
  const char* name;                        ///< "sensor_msgs/msg/Image"
  const dds_topic_descriptor_t* dds;       ///< its name on the wire and its layout in memory
  std::string_view text;                   ///< its .msg definition, without comments
  std::span<const RosType* const> uses{};  ///< the types of its fields
  /// Hash of a type that is sent as a message: "RIHS01_" and the SHA-256 of its description
  /// (REP-2011), which nodes since Iron compare.
  const char* hash = "";
};

// idlc's structures under the names that their users know.
using RosTime = builtin_interfaces_msg_dds__Time_;
using RosHeader = std_msgs_msg_dds__Header_;
using RosImage = sensor_msgs_msg_dds__Image_;
using RosCompressedImage = sensor_msgs_msg_dds__CompressedImage_;
using RosCameraInfo = sensor_msgs_msg_dds__CameraInfo_;
using RosRegion = sensor_msgs_msg_dds__RegionOfInterest_;
using RosPointField = sensor_msgs_msg_dds__PointField_;
using RosPointCloud = sensor_msgs_msg_dds__PointCloud2_;
using RosDisparity = stereo_msgs_msg_dds__DisparityImage_;
using RosTransform = geometry_msgs_msg_dds__TransformStamped_;
using RosTransforms = tf2_msgs_msg_dds__TFMessage_;
using RosKeyValue = diagnostic_msgs_msg_dds__KeyValue_;
using RosDiagnostic = diagnostic_msgs_msg_dds__DiagnosticStatus_;
using RosDiagnostics = diagnostic_msgs_msg_dds__DiagnosticArray_;
using RosGid = rmw_dds_common_msg_dds__Gid_;
using RosNodeEntities = rmw_dds_common_msg_dds__NodeEntitiesInfo_;
using RosParticipantEntities = rmw_dds_common_msg_dds__ParticipantEntitiesInfo_;

/// PointField's numbers of types.
inline constexpr uint8_t kRosUint8 = 2;
inline constexpr uint8_t kRosFloat32 = 7;
inline constexpr uint8_t kRosFloat64 = 8;

/// The type of a structure that is sent by itself.
template <typename T>
const RosType& RosTypeOf();

/// All types that this program knows.
std::span<const RosType* const> RosTypes();

/// The definition of a type and of all that it uses, as rosbag2 and Foxglove want it in a schema of
/// encoding "ros2msg".
std::string RosSchema(const RosType& type);

}  // namespace sprout
