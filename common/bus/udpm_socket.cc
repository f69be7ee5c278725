#include "common/bus/udpm_socket.h"

#include <linux/filter.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <chrono>
#include <cstdint>
#include <iterator>
#include <new>
#include <utility>
#include <vector>

namespace sprout {
namespace {

// How long the thread waits for a datagram before it looks whether it should stop.
constexpr timeval kPatience{.tv_sec = 0, .tv_usec = 100'000};
constexpr size_t kMaxDatagram = 65536;

// After so long without a datagram the group is joined again.
constexpr std::chrono::seconds kSilence{1};

// The thread runs at least every kPatience. Whoever did not for so long was stopped, or got no
// core.
constexpr std::chrono::milliseconds kStopped{250};

// Joins the group on the device to which its route leads. Of a device that is gone, as an adapter
// that is unplugged or a VPN that starts again, the kernel forgets who has joined.
bool Join(int fd, const in_addr& address) {
  ip_mreq group{};
  group.imr_multiaddr = address;
  return setsockopt(fd, IPPROTO_IP, IP_ADD_MEMBERSHIP, &group, sizeof group) == 0;
}

// Lets the kernel drop the datagrams of long messages, where it can.
void DropLong(int fd) {
  constexpr uint32_t kUdpHeader = 8;  // bytes before the magic number
  sock_filter program[] = {
      {.code = BPF_LD | BPF_W | BPF_ABS, .jt = 0, .jf = 0, .k = kUdpHeader},
      {.code = BPF_JMP | BPF_JEQ | BPF_K, .jt = 0, .jf = 1, .k = DatagramJoiner::kLongMagic},
      {.code = BPF_RET | BPF_K, .jt = 0, .jf = 0, .k = 0},
      {.code = BPF_RET | BPF_K, .jt = 0, .jf = 0, .k = UINT32_MAX}};
  const sock_fprog filter{.len = std::size(program), .filter = program};
  setsockopt(fd, SOL_SOCKET, SO_ATTACH_FILTER, &filter, sizeof filter);
}

// Listens on the group's address only: on any address all that is sent to this host would come,
// too. The port is shared with all other processes that listen there.
bool Listen(int fd, const UdpmAddress& address) {
  const int yes = 1;
  if (address.receive_buffer > 0) {
    setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &address.receive_buffer, sizeof address.receive_buffer);
  }
  return setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes) == 0 &&
         setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &kPatience, sizeof kPatience) == 0 &&
         bind(fd, reinterpret_cast<const sockaddr*>(&address.group), sizeof address.group) == 0 &&
         Join(fd, address.group.sin_addr);
}

int Open(const std::string& url, const UdpmAddress& address, bool short_only) {
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (fd >= 0 && short_only) DropLong(fd);
  if (fd >= 0 && Listen(fd, address)) return fd;
  if (fd >= 0) close(fd);
  throw BusError("cannot listen on LCM URL " + url + "; is its port in use?");
}

}  // namespace

UdpmSocket::UdpmSocket(const std::string& url, DatagramJoiner::Wanted wanted, bool short_only)
    : address_(RequireUdpmRoute(url)),
      socket_(Open(url, address_, short_only)),
      joiner_(std::move(wanted)) {}

UdpmSocket::~UdpmSocket() { close(socket_); }

void UdpmSocket::Receive(const std::stop_token& stop,
                         const std::function<void(DatagramJoiner::Message)>& on_message) {
  using Clock = std::chrono::steady_clock;
  std::vector<uint8_t> datagram(kMaxDatagram);
  Clock::time_point heard = Clock::now();
  Clock::time_point ran = heard;
  while (!stop.stop_requested()) {
    sockaddr_in sender{};
    socklen_t sender_bytes = sizeof sender;
    const ssize_t bytes =
        recvfrom(socket_, datagram.data(), datagram.size(), is_behind_ ? MSG_DONTWAIT : 0,
                 reinterpret_cast<sockaddr*>(&sender), &sender_bytes);
    const Clock::time_point now = Clock::now();
    if (now - std::exchange(ran, now) > kStopped) {
      is_behind_ = true;
    } else if (bytes <= 0) {
      is_behind_ = false;
    }
    if (bytes > 0 || now - heard > kSilence) heard = now;
    if (bytes <= 0) {
      // Where it is joined this does nothing.
      if (heard == now) Join(socket_, address_.group.sin_addr);
      continue;
    }
    try {
      auto message = joiner_.Add({sender.sin_addr.s_addr, sender.sin_port},
                                 std::span(datagram).first(static_cast<size_t>(bytes)), now);
      if (message) on_message(std::move(*message));
    } catch (const std::bad_alloc&) {  // as if it had been lost on the way
    }
  }
}

}  // namespace sprout
