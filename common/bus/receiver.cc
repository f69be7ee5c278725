#include "common/bus/receiver.h"

#include <chrono>
#include <condition_variable>
#include <mutex>

namespace sprout {
namespace {

// Messages that LCM holds until our thread takes them; its default of 30 is less than a second.
constexpr int kQueueCapacity = 100;

// How long the thread waits for a message before it looks whether it should stop.
constexpr int kPollMs = 100;

// How long it waits before it calls on a server again that hung up.
constexpr std::chrono::seconds kReconnectPeriod{1};

// False as soon as a stop is requested.
bool Sleep(std::chrono::milliseconds time, const std::stop_token& stop) {
  std::mutex mutex;
  std::condition_variable_any stopped;
  std::unique_lock lock(mutex);
  stopped.wait_for(lock, stop, time, [] { return false; });
  return !stop.stop_requested();
}

}  // namespace

Receiver::Receiver(const std::string& url, const std::string& prefix,
                   const std::vector<std::string_view>& channels, Handler handler)
    : prefix_length_(prefix.size()), handler_(std::move(handler)), lcm_(OpenLcm(url)) {
  for (const std::string_view channel : channels) {
    const std::string name = prefix + std::string(channel);
    lcm_subscription_t* subscription = lcm_subscribe(lcm_.get(), name.c_str(), &OnMessage, this);
    if (subscription == nullptr) throw BusError("cannot subscribe to " + name + " on " + url);
    lcm_subscription_set_queue_capacity(subscription, kQueueCapacity);
  }
  thread_ = std::jthread([this](const std::stop_token& stop) { Receive(stop); });
}

void Receiver::Receive(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    // A tcpq server that hung up leaves no connection; LCM would abort the program on it.
    if (lcm_get_fileno(lcm_.get()) < 0) {
      if (Sleep(kReconnectPeriod, stop)) Reconnect();
    } else if (lcm_handle_timeout(lcm_.get(), kPollMs) < 0) {
      Sleep(std::chrono::milliseconds(kPollMs), stop);
    }
  }
}

// On tcpq any subscription connects again first, and renews those that were there; nothing is ever
// sent on this channel.
void Receiver::Reconnect() {
  lcm_subscription_t* probe = lcm_subscribe(lcm_.get(), "SPROUT_RECONNECT", &OnMessage, this);
  if (probe != nullptr) lcm_unsubscribe(lcm_.get(), probe);
}

void Receiver::OnMessage(const lcm_recv_buf_t* buffer, const char* channel, void* self) {
  auto* receiver = static_cast<Receiver*>(self);
  receiver->handler_(std::string_view(channel).substr(receiver->prefix_length_),
                     {static_cast<const uint8_t*>(buffer->data), buffer->data_size});
}

}  // namespace sprout
