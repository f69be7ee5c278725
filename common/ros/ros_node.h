#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "common/config/config_error.h"
#include "common/ros/cdr.h"

namespace sprout {

/// How messages of a topic travel.
struct RosQos {
  bool reliable = true;  ///< lost ones are sent again; else as ROS's "sensor data"
  bool latched = false;  ///< late readers get the newest ones (transient local)
  int depth = 5;         ///< keep last: so many wait for a slow reader, then the oldest goes

  bool operator==(const RosQos&) const = default;
};

/// What a domain of DDS needs to know before the first node is in it.
struct RosNodeOptions {
  int domain = 0;    ///< as ROS_DOMAIN_ID
  std::string name;  ///< of the node: "sprout"
  /// Larger messages of other hosts are not taken, and count as lost.
  uint32_t max_message_bytes = uint32_t{1} << 30;
};

/// ROS_DOMAIN_ID; nothing when it is not set. @throws ConfigError when it is no domain.
std::optional<int> RosDomainOfEnvironment();

/// Takes what Cyclone DDS would print to stderr, which has no bounded rate: a peer can send
/// thousands of messages a second that are none. One at a time in a process.
class RosWarnings {
 public:
  /// Called by any thread. @param is_of_message  a message was refused: one of its kind each.
  using Warn = std::function<void(const std::string& text, bool is_of_message)>;
  explicit RosWarnings(Warn warn);
  ~RosWarnings();
  RosWarnings(const RosWarnings&) = delete;
  RosWarnings& operator=(const RosWarnings&) = delete;

 private:
  std::unique_ptr<Warn> warn_;  // Cyclone knows its address
};

/// A node of ROS 2's graph without ROS: its topics and types have ROS's names on the wire, and
/// ROS's tools show it with its topics. On Cyclone DDS, whose own configuration (CYCLONEDDS_URI)
/// says which network; see its manual. As ROS's own middleware it also obeys ROS_LOCALHOST_ONLY,
/// ROS_AUTOMATIC_DISCOVERY_RANGE and ROS_STATIC_PEERS.
/// Thread-safe, but for one reader or writer at a time.
class RosNode {
 public:
  /// @throws ConfigError when DDS cannot be used: no network, a domain that cannot be.
  explicit RosNode(const RosNodeOptions& options);
  ~RosNode();
  RosNode(const RosNode&) = delete;
  RosNode& operator=(const RosNode&) = delete;

  using Handle = int32_t;
  /// @param topic  "/sprout/points". @throws ConfigError.
  Handle AddReader(const std::string& topic, const RosType& type, const RosQos& qos);
  Handle AddWriter(const std::string& topic, const RosType& type, const RosQos& qos);
  void RemoveReader(Handle reader);

  /// Tells the others which topics this node has; call after adding and removing.
  void Announce();

  /// Whether somebody listens.
  bool HasReaders(Handle writer) const;

  /// Sends a message; never waits for readers. An error says what DDS has against it.
  Result<void> Write(Handle writer, const AnyRosMessage& message);

  /// A message of a reader.
  struct Taken {
    size_t bytes = 0;         ///< of the message
    bool is_too_big = false;  ///< then `cdr` is as it was
    uint64_t publisher = 0;   ///< a number for who sent it
  };
  /// Takes the oldest message of a reader as CDR; nothing when there is none.
  std::optional<Taken> Take(Handle reader, size_t max_bytes, std::vector<uint8_t>& cdr);

  /// How many messages newer ones are known to have replaced before they were taken
  /// (RosQos::depth), since the last call. DDS does not count them.
  int64_t TakeReplaced(Handle reader);

  /// Waits until a reader has a message, or until the time is over.
  void Wait(std::chrono::milliseconds longest);

  /// The policy for which somebody on the topic and this reader or writer did not come together
  /// since the last call: "RELIABILITY"; empty when there was none.
  std::string TakeMisfit(Handle reader_or_writer);

  /// The publishers of a topic that discovery knows, also those that died a moment ago.
  struct Publishers {
    int of_type = 0;
    int of_others = 0;
    std::string other_type = {};  ///< one of them, as on the wire
    RosQos offered = {};          ///< the least that those of the type offer; depth says nothing
  };
  Publishers PublishersOf(const std::string& topic, const RosType& type);

  /// Topics of a type that discovery knows publishers of: "/camera/left/image".
  std::set<std::string> TopicsOf(const RosType& type);

 private:
  struct Endpoint {
    std::string topic;
    std::string type;
    RosQos offered;
  };

  struct Reader {
    Handle has_data = 0;  // condition
    int64_t depth = 0;    // RosQos::depth
    std::atomic<int64_t> came = 0;
    int64_t taken = 0;
    int64_t replaced = 0;
    int64_t told = 0;  // of those
  };

  Handle AddTopic(const std::string& topic, const RosType& type);
  void Discover();

  std::string name_;
  Handle domain_ = 0;  // 0: another node of this process has made it
  Handle participant_ = 0;
  Handle publications_ = 0;  // reader of what discovery knows
  Handle waitset_ = 0;
  Handle graph_ = 0;                        // writer of ros_discovery_info
  std::map<uint64_t, Endpoint> endpoints_;  // of publishers, by their instances
  std::map<Handle, Reader> readers_;        // DDS knows their addresses
  std::vector<Handle> writers_;
};

/// The configuration of Cyclone DDS (XML) for a domain: what Sprout needs, behind it what ROS's
/// variables say of discovery, behind that CYCLONEDDS_URI. The last word counts.
/// @throws ConfigError for a value of a variable that cannot be.
std::string CycloneConfig(uint32_t max_message_bytes);

}  // namespace sprout
