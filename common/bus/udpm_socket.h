#pragma once

#include <atomic>
#include <functional>
#include <stop_token>
#include <string>

#include "common/bus/datagram_joiner.h"
#include "common/bus/lcm_url.h"

namespace sprout {

/// Receives the messages of LCM's multicast protocol. Takes only what is sent to the URL's group,
/// not what is sent to this host or to other groups on the same port. Not thread-safe.
class UdpmSocket {
 public:
  /// Listens from here on.
  /// @param url         udpm, without errors, see LcmUrlError().
  /// @param short_only  messages of more than one datagram are not heard; the kernel drops them,
  ///                    and does not wake this process for images that others send.
  /// @throws BusError when there is no multicast route, or the port cannot be bound.
  UdpmSocket(const std::string& url, DatagramJoiner::Wanted wanted, bool short_only);
  ~UdpmSocket();
  UdpmSocket(const UdpmSocket&) = delete;
  UdpmSocket& operator=(const UdpmSocket&) = delete;

  /// Hands over messages until a stop is requested, and 0.1 s longer at most. Goes on when a
  /// network device was replaced.
  void Receive(const std::stop_token& stop,
               const std::function<void(DatagramJoiner::Message)>& on_message);

  /// Whether Receive() did not run for a while, as in a process that was stopped, and has not read
  /// all that came meanwhile. Thread-safe.
  bool is_behind() const { return is_behind_; }

 private:
  UdpmAddress address_;
  int socket_;
  std::atomic<bool> is_behind_ = false;
  DatagramJoiner joiner_;
};

}  // namespace sprout
