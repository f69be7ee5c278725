#include "common/bus/receiver.h"

namespace sprout {
namespace {

// Messages that LCM holds until our thread takes them; its default of 30 is less than a second.
constexpr int kQueueCapacity = 100;

// How long the thread waits for a message before it looks whether it should stop.
constexpr int kPollMs = 100;

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
  thread_ = std::jthread([this](const std::stop_token& stop) {
    while (!stop.stop_requested()) lcm_handle_timeout(lcm_.get(), kPollMs);
  });
}

void Receiver::OnMessage(const lcm_recv_buf_t* buffer, const char* channel, void* self) {
  auto* receiver = static_cast<Receiver*>(self);
  receiver->handler_(std::string_view(channel).substr(receiver->prefix_length_),
                     {static_cast<const uint8_t*>(buffer->data), buffer->data_size});
}

}  // namespace sprout
