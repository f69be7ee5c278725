#include "common/bus/lcm_url.h"

#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <set>
#include <string_view>
#include <system_error>

#include "common/core/number_text.h"
#include "common/core/receive_buffer.h"

namespace sprout {
namespace {

constexpr char kUdpmScheme[] = "udpm://";
constexpr char kTcpqScheme[] = "tcpq://";
constexpr char kDefaultGroup[] = "239.255.76.67";
constexpr char kDefaultPort[] = "7667";
constexpr char kBufferKey[] = "recv_buf_size=";

struct ParsedUrl {
  bool is_tcpq = false;
  std::string host;
  std::string port;     // of udpm; a default where the URL has none, as for the host
  std::string options;  // behind the '?'
};

// Nothing for other kinds of URL.
std::optional<ParsedUrl> Parse(const std::string& url) {
  ParsedUrl parsed{.is_tcpq = url.starts_with(kTcpqScheme), .host = {}, .port = {}, .options = {}};
  if (!parsed.is_tcpq && !url.starts_with(kUdpmScheme)) return std::nullopt;
  const size_t start = url.find("://") + 3;
  const size_t question = std::min(url.find('?'), url.size());
  parsed.host = url.substr(start, question - start);
  if (question < url.size()) parsed.options = url.substr(question + 1);
  if (const size_t colon = parsed.host.find(':'); colon != std::string::npos) {
    parsed.port = parsed.host.substr(colon + 1);
    parsed.host = parsed.host.substr(0, colon);
  }
  if (parsed.is_tcpq) return parsed;
  if (parsed.host.empty()) parsed.host = kDefaultGroup;
  if (parsed.port.empty()) parsed.port = kDefaultPort;
  return parsed;
}

sockaddr_in GroupOf(const ParsedUrl& url) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<uint16_t>(std::atoi(url.port.c_str())));
  if (inet_pton(AF_INET, url.host.c_str(), &address.sin_addr) != 1) address.sin_addr.s_addr = 0;
  return address;
}

bool IsNumber(std::string_view text, int64_t low, int64_t high) {
  const auto number = ParseNumber<int64_t>(text);
  return number && *number >= low && *number <= high;
}

// What is wrong with "ttl=0&recv_buf_size=1000"; LCM takes ',' for '&', too.
std::optional<std::string> OptionsError(std::string_view options) {
  std::set<std::string_view> names;
  while (!options.empty()) {
    const size_t end = std::min(options.find_first_of("&,"), options.size());
    const std::string_view option = options.substr(0, end);
    options.remove_prefix(std::min(end + 1, options.size()));
    const std::string_view value = option.substr(std::min(option.find('=') + 1, option.size()));
    const bool is_new = names.insert(option.substr(0, option.find('='))).second;
    if (is_new &&
        (option.starts_with("ttl=") ? IsNumber(value, 0, 255)
                                    : option.starts_with("recv_buf_size=") &&
                                          IsNumber(value, 1, std::numeric_limits<int>::max()))) {
      continue;
    }
    return "'" + std::string(option) +
           "'; allowed: ttl=0 to ttl=255, recv_buf_size=BYTES, each once";
  }
  return std::nullopt;
}

// What is wrong with port and options, and with the group; nothing if all is right.
std::optional<std::string> NetworkError(const ParsedUrl& url) {
  if (!url.port.empty() && !IsNumber(url.port, 1, 65535)) {
    return "port '" + url.port + "'; allowed: 1 to 65535";
  }
  if (url.is_tcpq) {
    if (url.options.empty()) return std::nullopt;
    return "'" + url.options + "'; allowed: tcpq://HOST:PORT, without options";
  }
  if (!IN_MULTICAST(ntohl(GroupOf(url).sin_addr.s_addr))) {
    return "'" + url.host + "' is no multicast group; allowed: 224.0.0.0 to 239.255.255.255";
  }
  return OptionsError(url.options);
}

// What a URL asks for behind a key, "ttl="; 0 = nothing.
long long Asked(const std::string& url, const std::string& key) {
  const size_t at = url.find(key);
  return at == std::string::npos ? 0 : std::atoll(url.c_str() + at + key.size());
}

// Whether the kernel knows a way to the group. Sends nothing: connecting a datagram socket only
// looks up the route.
bool HasRoute(const sockaddr_in& group) {
  const int fd = socket(AF_INET, SOCK_DGRAM, 0);
  if (fd < 0)
    throw BusError("cannot open a UDP socket (" + std::generic_category().message(errno) + ")");
  const bool connected = connect(fd, reinterpret_cast<const sockaddr*>(&group), sizeof group) == 0;
  close(fd);
  return connected;
}

}  // namespace

std::optional<std::string> LcmUrlError(const std::string& url) {
  const std::optional<ParsedUrl> parsed = Parse(url);
  const std::optional<std::string> error =
      parsed ? NetworkError(*parsed)
             : "no such kind; allowed: udpm://GROUP:PORT?ttl=0, tcpq://HOST:PORT";
  if (!error) return std::nullopt;
  return "LCM URL " + url + ": " + *error;
}

bool IsUdpm(const std::string& url) { return url.starts_with(kUdpmScheme); }

UdpmAddress RequireUdpmRoute(const std::string& url) {
  if (const auto error = LcmUrlError(url)) throw BusError(*error);
  const ParsedUrl parsed = *Parse(url);
  const UdpmAddress address{.group = GroupOf(parsed),
                            .receive_buffer = static_cast<int>(Asked(url, kBufferKey))};
  if (!HasRoute(address.group)) {
    const std::string add = "ip route add " + parsed.host + "/32 dev ";
    throw BusError("no multicast route to " + parsed.host + "; add one: " +
                   (Asked(url, "ttl=") > 0 ? add + "DEVICE, the one that leads to the other hosts"
                                           : "ip link set lo multicast on && " + add + "lo"));
  }
  return address;
}

LcmPtr OpenLcm(const std::string& url) {
  if (const auto error = LcmUrlError(url)) throw BusError(*error);
  const ParsedUrl parsed = *Parse(url);
  if (!parsed.is_tcpq) RequireUdpmRoute(url);
  // Written in full: LCM takes 0 for a group or port that a URL lacks.
  const std::string whole =
      parsed.is_tcpq ? url : kUdpmScheme + parsed.host + ":" + parsed.port + "?" + parsed.options;
  LcmPtr lcm(lcm_create(whole.c_str()));
  // With tcpq LCM starts without a server, and aborts the program later, when it waits for a
  // message on the missing connection.
  if (!lcm || (parsed.is_tcpq && lcm_get_fileno(lcm.get()) < 0)) {
    throw BusError("cannot open LCM URL " + url +
                   (parsed.is_tcpq ? "; is its server running?" : ""));
  }
  return lcm;
}

std::optional<std::string> ReceiveBufferWarning(const std::string& url) {
  const long long asked = Asked(url, kBufferKey);
  if (!IsUdpm(url) || asked == 0) return std::nullopt;
  return ReceiveBufferShortage(asked);
}

}  // namespace sprout
