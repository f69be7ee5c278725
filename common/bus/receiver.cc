#include "common/bus/receiver.h"

#include <chrono>
#include <new>
#include <utility>

namespace sprout {
namespace {

// What LCM holds until our thread takes it, which does no more than copy it: without limit.
constexpr int kQueueCapacity = 0;

// What a message in our queue takes beside its bytes.
constexpr size_t kOverheadBytes = 128;

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
                   const std::vector<std::string_view>& channels, Handler handler, Dropped dropped,
                   size_t max_queued_bytes)
    : prefix_length_(prefix.size()),
      handler_(std::move(handler)),
      dropped_(std::move(dropped)),
      max_queued_bytes_(max_queued_bytes),
      lcm_(OpenLcm(url)) {
  for (const std::string_view channel : channels) {
    const std::string name = prefix + std::string(channel);
    lcm_subscription_t* subscription = lcm_subscribe(lcm_.get(), name.c_str(), &OnMessage, this);
    if (subscription == nullptr) throw BusError("cannot subscribe to " + name + " on " + url);
    lcm_subscription_set_queue_capacity(subscription, kQueueCapacity);
  }
  handling_ = std::jthread([this](const std::stop_token& stop) { Handle(stop); });
  receiving_ = std::jthread([this](const std::stop_token& stop) { Receive(stop); });
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
  const std::string_view name = std::string_view(channel).substr(receiver->prefix_length_);
  const std::span bytes{static_cast<const uint8_t*>(buffer->data), size_t{buffer->data_size}};
  if (!receiver->Enqueue(name, bytes) && receiver->dropped_) receiver->dropped_(name);
}

bool Receiver::Enqueue(std::string_view channel, std::span<const uint8_t> bytes) {
  try {
    Message message{.channel = std::string(channel), .bytes = {bytes.begin(), bytes.end()}};
    const std::lock_guard lock(mutex_);
    if (queued_bytes_ + bytes.size() + kOverheadBytes > max_queued_bytes_) return false;
    queue_.push_back(std::move(message));
    queued_bytes_ += bytes.size() + kOverheadBytes;
  } catch (const std::bad_alloc&) {  // must not cross LCM's C frames
    return false;
  }
  filled_.notify_one();
  return true;
}

void Receiver::Handle(const std::stop_token& stop) {
  while (true) {
    std::unique_lock lock(mutex_);
    filled_.wait(lock, stop, [this] { return !queue_.empty(); });
    if (stop.stop_requested()) return;
    const Message message = std::move(queue_.front());
    queue_.pop_front();
    queued_bytes_ -= message.bytes.size() + kOverheadBytes;
    lock.unlock();
    handler_(message.channel, message.bytes);
  }
}

}  // namespace sprout
