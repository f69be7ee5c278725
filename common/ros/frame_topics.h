#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "common/core/frame.h"
#include "common/ros/cdr.h"
#include "common/ros/to_ros.h"

namespace sprout {

/// What of the graph is shown to ROS: the topics, in the order of kRosTopics.
enum class RosTopic {
  kLeft,
  kLeftInfo,
  kRight,
  kRightInfo,
  kDepth,
  kDepthInfo,
  kDepthSigma,
  kPoints,
  kDisparity,
  kConfidence,
  kFused,
  kFusedConfidence,
  kTof,
  kTofAmplitude,
  kTofInfo,
  kTransforms,
  kDiagnostics,
};

/// What there is to know about a topic.
struct RosTopicRow {
  RosTopic topic;
  std::string_view name;  ///< without the prefix; one that begins with '/' gets none
  const RosType& (*type)();
  Part part;               ///< that it is made of; kDiagnostics is made of none
  bool needs_rig = false;  ///< beside the part
};

std::span<const RosTopicRow> RosTopicRows();
const RosTopicRow& RowOf(RosTopic topic);

/// "/sprout/depth/image_rect": the name of a topic with the prefix "/sprout".
std::string RosTopicName(const RosTopicRow& row, std::string_view prefix);

struct RosTopicOptions {
  RosFrames frames;
  RosDepth depth = RosDepth::kMillimetres;
};

/// The message of a topic for a part of a frame; nothing when it is not a part of the topic's, or
/// one that cannot be shown (an image of 0×0).
/// @param rig  calibration of the frame; needed where row.needs_rig, null when it is not known.
std::unique_ptr<AnyRosMessage> ToRos(RosTopic topic, const FrameId& id, const PartValue& value,
                                     const Rig* rig, const RosTopicOptions& options);

}  // namespace sprout
