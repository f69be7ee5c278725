#include "tests/system/relay.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <list>
#include <map>
#include <stdexcept>
#include <utility>
#include <vector>

namespace sprout {
namespace {

constexpr char kGroup[] = "239.255.76.67";
constexpr size_t kLargestDatagram = 65536;
constexpr int kPollMs = 20;  // without traffic, what waits is delivered

sockaddr_in AddressOf(uint16_t port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  inet_pton(AF_INET, kGroup, &address.sin_addr);
  return address;
}

int OpenListener(uint16_t port) {
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  const sockaddr_in address = AddressOf(port);
  ip_mreq group{};
  group.imr_multiaddr = address.sin_addr;
  const int yes = 1;
  const int buffer = 64 << 20;
  setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &buffer, sizeof buffer);
  if (fd < 0 || bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
      setsockopt(fd, IPPROTO_IP, IP_ADD_MEMBERSHIP, &group, sizeof group) != 0) {
    throw std::runtime_error("relay: cannot listen");
  }
  return fd;
}

using Datagram = std::vector<uint8_t>;

// The sockets that stand for the senders.
class Senders {
 public:
  Senders() = default;
  ~Senders() {
    for (const auto& [address, fd] : sockets_) close(fd);
  }
  Senders(const Senders&) = delete;
  Senders& operator=(const Senders&) = delete;

  int SocketOf(const sockaddr_in& sender) {
    const std::pair key{sender.sin_addr.s_addr, sender.sin_port};
    if (const auto found = sockets_.find(key); found != sockets_.end()) return found->second;
    const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    const sockaddr_in to = AddressOf(Relay::kTo);
    const int buffer = 8 << 20;
    setsockopt(fd, SOL_SOCKET, SO_SNDBUF, &buffer, sizeof buffer);
    if (connect(fd, reinterpret_cast<const sockaddr*>(&to), sizeof to) != 0) {
      throw std::runtime_error("relay: cannot send");
    }
    return sockets_[key] = fd;
  }

 private:
  std::map<std::pair<in_addr_t, in_port_t>, int> sockets_;
};

void Send(int fd, const Datagram& datagram) {
  static_cast<void>(send(fd, datagram.data(), datagram.size(), 0));
}

struct Waiting {
  int fd;
  Datagram datagram;
  int after;  // so many others
};

}  // namespace

Relay::Relay(uint32_t seed) : random_(seed), socket_(OpenListener(kFrom)) {
  thread_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
}

Relay::~Relay() {
  thread_.request_stop();
  thread_.join();
  close(socket_);
}

void Relay::Set(const NetworkFaults& faults) {
  lost_share_ = faults.lost;
  doubled_share_ = faults.doubled;
  reordered_share_ = faults.reordered;
}

void Relay::Run(const std::stop_token& stop) {
  Senders senders;
  std::list<Waiting> waiting;
  const auto happens = [&](double share) {
    return std::uniform_real_distribution(0.0, 1.0)(random_) < share;
  };
  Datagram datagram(kLargestDatagram);
  pollfd readable{.fd = socket_, .events = POLLIN, .revents = 0};
  while (!stop.stop_requested()) {
    if (poll(&readable, 1, kPollMs) <= 0) {
      for (const Waiting& held : waiting) Send(held.fd, held.datagram);
      waiting.clear();
      continue;
    }
    sockaddr_in sender{};
    socklen_t size = sizeof sender;
    datagram.resize(kLargestDatagram);
    const ssize_t bytes = recvfrom(socket_, datagram.data(), datagram.size(), 0,
                                   reinterpret_cast<sockaddr*>(&sender), &size);
    if (bytes < 0) continue;
    datagram.resize(static_cast<size_t>(bytes));
    ++datagrams_;
    const int fd = senders.SocketOf(sender);
    if (happens(lost_share_)) {
      ++lost_;
    } else if (happens(reordered_share_)) {
      waiting.push_back({fd, datagram, std::uniform_int_distribution(1, 4)(random_)});
      continue;
    } else {
      Send(fd, datagram);
      if (happens(doubled_share_)) Send(fd, datagram);
    }
    for (auto held = waiting.begin(); held != waiting.end();) {
      if (--held->after > 0) {
        ++held;
        continue;
      }
      Send(held->fd, held->datagram);
      held = waiting.erase(held);
    }
  }
}

}  // namespace sprout
