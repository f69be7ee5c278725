#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/app/stage_monitor.h"
#include "common/config/config.h"
#include "common/core/rig.h"
#include "common/core/stage_status.h"
#include "common/frames/sequence_gaps.h"
#include "common/messages/codec.h"
#include "common/ros/frame_topics.h"
#include "common/ros/ros_node.h"

namespace sprout::ros2 {

using AnyRosMessagePtr = std::unique_ptr<AnyRosMessage>;

/// Shows the messages of the graph to ROS 2. A message is decoded and converted only when somebody
/// subscribes to a topic that is made of it. Its methods may be called from any thread.
class Bridge {
 public:
  /// @param depth  configuration of sprout-depth: of which frames and pixels it sends depth.
  /// @throws ConfigError for a name that cannot be, or when DDS cannot be used.
  Bridge(const Ros2Config& config, const DepthConfig& depth, StageMonitor& monitor);

  /// The channels (without prefix) that somebody wants now, and those that are always listened to.
  std::set<std::string_view> WantedChannels() const;

  /// The channels that are received from here on. Frame numbers that one of them left out while it
  /// was not received are not missing.
  void ReceivesOnly(const std::set<std::string_view>& channels);

  /// Takes a message of the graph.
  void OnMessage(std::string_view channel, std::span<const uint8_t> bytes);

  /// Publishes the state of the processes, and warns of subscribers that cannot be served; call
  /// once a second.
  void PublishDiagnostics();

  int64_t converted() const { return converted_; }  ///< messages for ROS so far

 private:
  struct Topic {
    const RosTopicRow* row;
    std::string name;
    bool is_compressed;
    RosNode::Handle writer;
  };

  using Clock = std::chrono::steady_clock;
  struct Heard {
    StageStatus status;
    Clock::time_point when;
  };

  void OnPart(Part part, std::span<const uint8_t> bytes);
  void OnRig(std::span<const uint8_t> bytes);
  void OnStatus(std::span<const uint8_t> bytes);
  bool IsWanted(Part part) const;
  void CountGaps(Part part, const FrameId& id);
  AnyRosMessagePtr Converted(const Topic& topic, const DecodedPart& part, const Rig* rig) const;
  Result<AnyRosMessagePtr> OrderedPoints(const DecodedPart& cloud, const Rig& rig) const;
  bool Publish(const Topic& topic, const FrameId& id, const AnyRosMessage& message);
  void WarnOfMisfits();

  Ros2Config config_;
  int depth_every_;
  int cloud_stride_;
  StageMonitor& monitor_;
  RosTopicOptions options_;
  RosNode node_;
  std::vector<Topic> topics_;
  std::mutex mutex_;
  std::map<std::string, Rig> rigs_;    // by rig_id
  std::deque<std::string> rig_order_;  // the newest last
  std::string newest_rig_;
  std::map<std::string, Heard> statuses_;
  std::map<Part, SequenceGaps> gaps_;  // of the channels that are received
  int64_t earlier_gaps_ = 0;           // of channels that are received no longer
  int64_t converted_ = 0;
};

}  // namespace sprout::ros2
