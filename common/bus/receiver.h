#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "common/bus/datagram_joiner.h"
#include "common/bus/lcm_url.h"
#include "common/bus/udpm_socket.h"

namespace sprout {

/// Receives messages on its own connection: udpm with a socket of its own (DatagramJoiner says
/// why), tcpq with LCM. One thread always drains it, since what does not fit into the kernel's
/// queues is lost silently; another one handles the messages in their order.
class Receiver {
 public:
  /// Called on the receiver's second thread with the channel (without prefix) and the message's
  /// bytes; as a span they are valid during the call. A message whose handler throws counts as
  /// dropped.
  using Handler = std::function<void(std::string_view channel, const MessageBytes& bytes)>;

  /// Called for each message that is dropped: on the first thread because the handler is too slow,
  /// on the second because it threw. Must be thread-safe and quick, and must not throw.
  using Dropped = std::function<void(std::string_view channel)>;

  /// Takes the place of a list of channels: all channels.
  static constexpr std::string_view kAllChannels = ".*";

  /// Most bytes that wait for the handler: two of the largest messages, some 20 frames of 2 MP.
  static constexpr size_t kMaxQueuedBytes = size_t{1} << 29;

  /// What the type and the frame of a message are read from.
  static constexpr size_t kHeadBytes = 1024;

  /// Subscribes to the channels, or to all of them (kAllChannels), and starts to receive before it
  /// returns. When a tcpq server closes the connection later, reconnects every second; what was
  /// sent in between is lost.
  /// @param max_queued_bytes  messages beyond it are dropped.
  /// @param heads  of these channels, beside the others, no more than the first kHeadBytes are
  ///               needed (with tcpq all come).
  /// @throws BusError, see OpenLcm().
  Receiver(const std::string& url, const std::string& prefix,
           const std::vector<std::string_view>& channels, Handler handler, Dropped dropped = {},
           size_t max_queued_bytes = kMaxQueuedBytes,
           const std::vector<std::string_view>& heads = {});

  /// Stops within 0.1 s; the handler is not called any more.
  ~Receiver() = default;

  /// Whether this process was stopped, or got no core, for more than a quarter of a second, and has
  /// not handled all that came meanwhile. With udpm; of tcpq it is not known. Thread-safe.
  bool IsBehind();

  Receiver(const Receiver&) = delete;
  Receiver& operator=(const Receiver&) = delete;

 private:
  struct Message {
    std::string channel;  // without prefix
    MessageBytes bytes;
    bool is_late;  // came while we did not run
  };

  void Subscribe(const std::vector<std::string>& names, const std::string& url);
  void ReceiveTcpq(const std::stop_token& stop);
  void Reconnect();
  void Enqueue(std::string_view name, MessageBytes bytes);
  void Handle(const std::stop_token& stop);
  static void OnMessage(const lcm_recv_buf_t* buffer, const char* channel, void* self);

  size_t prefix_length_;
  Handler handler_;
  Dropped dropped_;
  size_t max_queued_bytes_;
  std::mutex mutex_;
  std::condition_variable_any filled_;
  std::deque<Message> queue_;
  size_t queued_bytes_ = 0;
  size_t late_ = 0;                 // messages queued or being handled
  std::optional<UdpmSocket> udpm_;  // one of the two
  LcmPtr tcpq_;
  // The last member, so that the thread stops before the rest is destroyed.
  std::jthread handling_;
  std::jthread receiving_;
};

}  // namespace sprout
