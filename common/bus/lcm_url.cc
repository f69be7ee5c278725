#include "common/bus/lcm_url.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <string_view>

namespace sprout {
namespace {

constexpr char kUdpmScheme[] = "udpm://";
constexpr char kTcpqScheme[] = "tcpq://";
constexpr char kDefaultGroup[] = "239.255.76.67";
constexpr uint16_t kDefaultPort = 7667;

struct Group {
  std::string address = kDefaultGroup;
  uint16_t port = kDefaultPort;
};

// Multicast group of a udpm URL (either half may be missing); nothing for other kinds of URL.
std::optional<Group> MulticastGroup(const std::string& url) {
  if (!url.starts_with(kUdpmScheme)) return std::nullopt;
  const size_t start = std::string_view(kUdpmScheme).size();
  const std::string network = url.substr(start, url.find('?') - start);
  Group group;
  const size_t colon = network.find(':');
  if (!network.substr(0, colon).empty()) group.address = network.substr(0, colon);
  if (colon != std::string::npos) {
    group.port = static_cast<uint16_t>(std::atoi(network.substr(colon + 1).c_str()));
  }
  return group;
}

// Whether the kernel knows a way to the group. Sends nothing: connecting a datagram socket only
// looks up the route.
bool HasRoute(const Group& group) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(group.port);
  if (inet_pton(AF_INET, group.address.c_str(), &address.sin_addr) != 1) {
    throw BusError("LCM URL: '" + group.address +
                   "' is no IPv4 address; allowed: udpm://A.B.C.D:PORT");
  }
  const int fd = socket(AF_INET, SOCK_DGRAM, 0);
  if (fd < 0) throw BusError("cannot open a UDP socket");
  const bool connected =
      connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  close(fd);
  return connected;
}

}  // namespace

LcmPtr OpenLcm(const std::string& url) {
  if (const std::optional<Group> group = MulticastGroup(url); group && !HasRoute(*group)) {
    throw BusError("no multicast route to " + group->address +
                   "; add one: ip link set lo multicast on && ip route add " + group->address +
                   "/32 dev lo");
  }
  LcmPtr lcm(lcm_create(url.c_str()));
  // On tcpq LCM is content without a server, and aborts the program later, when it waits for a
  // message on a connection that is none.
  if (!lcm || (url.starts_with(kTcpqScheme) && lcm_get_fileno(lcm.get()) < 0)) {
    throw BusError(
        "cannot open LCM URL " + url +
        "; allowed: udpm://GROUP:PORT?ttl=0, tcpq://HOST:PORT (with its server running)");
  }
  return lcm;
}

std::optional<std::string> ReceiveBufferWarning(const std::string& url) {
  const std::string key = "recv_buf_size=";
  const size_t at = url.find(key);
  if (!url.starts_with(kUdpmScheme) || at == std::string::npos) return std::nullopt;
  const long long asked = std::atoll(url.c_str() + at + key.size());
  long long granted = 0;
  if (!(std::ifstream("/proc/sys/net/core/rmem_max") >> granted) || granted >= asked) {
    return std::nullopt;
  }
  return "the kernel grants a receive buffer of " + std::to_string(granted) + " of " +
         std::to_string(asked) +
         " bytes: large frames may be lost; raise it: sysctl -w net.core.rmem_max=" +
         std::to_string(asked) + " (scripts/setup does it)";
}

}  // namespace sprout
