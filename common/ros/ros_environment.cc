#include <fmt/core.h>
#include <unistd.h>

#include <cstdlib>
#include <optional>
#include <vector>

#include "common/core/number_text.h"
#include "common/ros/ros_node.h"

namespace sprout {
namespace {

constexpr int kMaxDomain = 232;  // whose ports UDP has

std::string Variable(const char* name) {
  const char* const value = std::getenv(name);
  return value != nullptr ? value : "";
}

// An image is thousands of Cyclone's default datagrams. 64 kB are the most that UDP has, and what
// Fast DDS sends; its receive buffer must hold the burst of an image.
//
// The buffer that the kernel gives other people's sockets holds three of these datagrams: of a
// large message some must be sent again, in several rounds. A round begins with a heartbeat, which
// comes every 100 ms by Cyclone's default and here every 10, and a reader of ours answers it as
// fast.
//
// A writer keeps the newest messages of a topic for its readers, some MB each; Cyclone's own limit
// of 500 kB would let it wait for the slowest reader, a dead one, too. At the end nobody is waited
// for either.
std::string Network(uint32_t max_message_bytes) {
  return fmt::format(
      "<General><MaxMessageSize>65500B</MaxMessageSize><FragmentSize>65000B</FragmentSize>"
      "</General><Internal><SocketReceiveBufferSize min=\"default\" max=\"32MB\"/>"
      "<MaxSampleSize>{}B</MaxSampleSize>"
      "<HeartbeatInterval min=\"5ms\" minsched=\"5ms\" max=\"1s\">10ms</HeartbeatInterval>"
      "<NackDelay>10ms</NackDelay>"
      "<Watermarks><WhcAdaptive>false</WhcAdaptive><WhcHigh>1GB</WhcHigh></Watermarks>"
      "<WriterLingerDuration>0ms</WriterLingerDuration></Internal>",
      max_message_bytes);
}

// Which participants are looked for, as rmw_dds_common reads the variables.
struct Discovery {
  bool by_multicast = true;
  bool only_loopback = false;
  std::vector<std::string> peers;
};

// "one;two"
std::vector<std::string> StaticPeers() {
  std::vector<std::string> peers;
  const std::string text = Variable("ROS_STATIC_PEERS");
  for (const std::string_view peer : SplitAt(';', text)) {
    if (peer.find_first_of("<>&\"' ") != std::string::npos) {
      throw ConfigError("ROS_STATIC_PEERS = '" + text +
                        "': allowed are hosts, with ; between them");
    }
    if (!peer.empty()) peers.emplace_back(peer);
  }
  return peers;
}

Discovery DiscoveryOfEnvironment() {
  Discovery discovery{.peers = StaticPeers()};
  const std::string range = Variable("ROS_AUTOMATIC_DISCOVERY_RANGE");
  if (range == "LOCALHOST") {
    discovery.by_multicast = false;
    discovery.peers.emplace_back("localhost");
  } else if (range == "OFF") {
    discovery = {.by_multicast = false, .only_loopback = false, .peers = {}};
  } else if (range == "SYSTEM_DEFAULT") {
    discovery.peers.clear();
  } else if (!range.empty() && range != "SUBNET") {
    throw ConfigError("ROS_AUTOMATIC_DISCOVERY_RANGE = '" + range +
                      "': allowed are SUBNET, LOCALHOST, OFF, SYSTEM_DEFAULT");
  }
  // What Humble has in place of the other two; where all are set it counts.
  if (Variable("ROS_LOCALHOST_ONLY") == "1") {
    discovery = {.by_multicast = false, .only_loopback = true, .peers = {"localhost"}};
  }
  return discovery;
}

std::string Xml(const Discovery& discovery) {
  std::string general;
  if (!discovery.by_multicast) general += "<AllowMulticast>false</AllowMulticast>";
  if (discovery.only_loopback) {
    general += "<Interfaces><NetworkInterface address=\"127.0.0.1\"/></Interfaces>";
  }
  std::string xml;
  if (!general.empty()) xml += "<General>" + general + "</General>";
  if (!discovery.by_multicast && discovery.peers.empty()) {
    // A name that nobody else has.
    return xml + fmt::format(
                     "<Discovery><ParticipantIndex>none</ParticipantIndex>"
                     "<Tag>off_{}</Tag></Discovery>",
                     getpid());
  }
  if (discovery.peers.empty()) return xml;
  // Peers without multicast are found at the ports of the first 32 participants of a host.
  xml +=
      "<Discovery><ParticipantIndex>auto</ParticipantIndex>"
      "<MaxAutoParticipantIndex>32</MaxAutoParticipantIndex><Peers>";
  for (const std::string& peer : discovery.peers) xml += "<Peer address=\"" + peer + "\"/>";
  return xml + "</Peers></Discovery>";
}

}  // namespace

std::optional<int> RosDomainOfEnvironment() {
  const std::string text = Variable("ROS_DOMAIN_ID");
  if (text.empty()) return std::nullopt;
  const std::optional<int> domain = ParseNumber<int>(text);
  if (domain && *domain >= 0 && *domain <= kMaxDomain) return domain;
  throw ConfigError(fmt::format("ROS_DOMAIN_ID = '{}': allowed is 0 to {}", text, kMaxDomain));
}

std::string CycloneConfig(uint32_t max_message_bytes) {
  std::string config = "<CycloneDDS><Domain id=\"any\">" + Network(max_message_bytes) +
                       Xml(DiscoveryOfEnvironment()) + "</Domain></CycloneDDS>";
  const std::string asked = Variable("CYCLONEDDS_URI");
  return asked.empty() ? config : config + "," + asked;
}

}  // namespace sprout
