#pragma once

#include <lcm/lcm.h>
#include <netinet/in.h>

#include <memory>
#include <optional>
#include <stdexcept>
#include <string>

namespace sprout {

/// The network cannot be used. what() is one line that says what to do. Programs end with exit
/// code 1.
class BusError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Stays on this host (ttl=0) and asks for a receive buffer that holds some frames of 2 MP: with
/// the kernel's default most large messages are lost.
inline constexpr char kDefaultLcmUrl[] = "udpm://239.255.76.67:7667?ttl=0&recv_buf_size=67108864";

struct LcmDeleter {
  void operator()(lcm_t* lcm) const { lcm_destroy(lcm); }
};
using LcmPtr = std::unique_ptr<lcm_t, LcmDeleter>;

/// What is wrong with an LCM URL, in one line that names it and what is allowed; nothing when it is
/// valid. LCM itself accepts an impossible time to live or host, and then reaches nobody.
std::optional<std::string> LcmUrlError(const std::string& url);

/// Whether it is udpm://..., multicast, not tcpq.
bool IsUdpm(const std::string& url);

/// Where a udpm URL listens, and its receive buffer, bytes; 0 = the kernel's default.
struct UdpmAddress {
  sockaddr_in group;
  int receive_buffer = 0;
};

/// @param url  udpm.
/// @throws BusError when the URL has an error, or there is no multicast route.
UdpmAddress RequireUdpmRoute(const std::string& url);

/// Connects. Every thread needs a connection of its own: publishing on a shared one is not safe on
/// tcpq.
/// @throws BusError when the URL has an error, no server answers, or there is no multicast route
///         (checked first, since LCM itself needs seconds and many lines to report it).
LcmPtr OpenLcm(const std::string& url);

/// One line of warning when the kernel will grant a smaller receive buffer than the URL asks for.
/// LCM does not report this; frames get lost.
std::optional<std::string> ReceiveBufferWarning(const std::string& url);

}  // namespace sprout
