#ifndef SPROUT_COMMON_ROS2_ROS_NODE_H_
#define SPROUT_COMMON_ROS2_ROS_NODE_H_

#include <chrono>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/ros2/cdr.h"

namespace sprout {

/// DDS cannot be used: no network, a domain that cannot be.
class RosError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// How messages of a topic travel.
struct RosQos {
  bool reliable = false;  ///< lost ones are sent again; else as ROS's "sensor data"
  bool latched = false;   ///< late readers get the newest one (transient local)
  int depth = 1;          ///< keep last; 0: all, so that a reliable writer never drops one unseen
};

/// A participant of ROS 2's graph without ROS: topics and types have its names on the wire. On
/// Cyclone DDS, whose own configuration (CYCLONEDDS_URI) says which network; see its manual.
/// Thread-safe, but for one reader or writer at a time.
class RosNode {
 public:
  /// @param domain  as ROS_DOMAIN_ID.
  /// @throws RosError.
  explicit RosNode(int domain);
  ~RosNode();
  RosNode(const RosNode&) = delete;
  RosNode& operator=(const RosNode&) = delete;

  using Handle = int32_t;
  /// @param topic  "/sprout/points". @throws RosError.
  Handle AddReader(const std::string& topic, const RosType& type, const RosQos& qos);
  Handle AddWriter(const std::string& topic, const RosType& type, const RosQos& qos);

  /// Whether somebody listens.
  bool HasReaders(Handle writer) const;

  /// Sends a message. An error when a reader of a reliable topic did not take it within 0.1 s.
  Result<void> Write(Handle writer, const AnyRosMessage& message);

  /// Takes the oldest message of a reader, as CDR. @returns false when there is none.
  bool Take(Handle reader, std::vector<uint8_t>& cdr);

  /// Waits until a reader has a message, or until the time is over.
  void Wait(std::chrono::milliseconds longest);

  /// Who publishes a topic, as far as discovery knows.
  struct Publishers {
    int of_type = 0;
    int of_others = 0;
    std::string other_type;  ///< one of them, as on the wire
  };
  Publishers PublishersOf(const std::string& topic, const RosType& type) const;

 private:
  Handle AddTopic(const std::string& topic, const RosType& type);

  Handle participant_ = 0;
  Handle publications_ = 0;  // reader of what discovery knows
  Handle waitset_ = 0;
};

}  // namespace sprout

#endif  // SPROUT_COMMON_ROS2_ROS_NODE_H_
