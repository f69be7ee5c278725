#ifndef SPROUT_COMMON_BUS_RECEIVER_H_
#define SPROUT_COMMON_BUS_RECEIVER_H_

#include <cstdint>
#include <functional>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "common/bus/lcm_url.h"

namespace sprout {

/// Receives messages on a thread and a connection of its own that always drains: LCM drops the
/// newest message, without a word, when its queue is full.
class Receiver {
 public:
  /// Called on the receiver's thread with the channel (without prefix) and the message's bytes,
  /// valid during the call. Must be quick and must not throw.
  using Handler = std::function<void(std::string_view channel, std::span<const uint8_t> bytes)>;

  /// Subscribes and starts to receive before it returns. When a tcpq server hangs up later, calls
  /// on it again every second; what was sent in between is lost.
  /// @throws BusError, see OpenLcm().
  Receiver(const std::string& url, const std::string& prefix,
           const std::vector<std::string_view>& channels, Handler handler);

  /// Stops within 0.1 s; the handler is not called any more.
  ~Receiver() = default;

  Receiver(const Receiver&) = delete;
  Receiver& operator=(const Receiver&) = delete;

 private:
  void Receive(const std::stop_token& stop);
  void Reconnect();
  static void OnMessage(const lcm_recv_buf_t* buffer, const char* channel, void* self);

  size_t prefix_length_;
  Handler handler_;
  LcmPtr lcm_;
  std::jthread thread_;  // last: stops before the rest is destroyed
};

}  // namespace sprout

#endif  // SPROUT_COMMON_BUS_RECEIVER_H_
