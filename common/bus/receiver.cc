#include "common/bus/receiver.h"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <new>
#include <utility>

#include "common/bus/channels.h"
#include "common/core/sleep.h"

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

}  // namespace

Receiver::Receiver(const std::string& url, const std::string& prefix,
                   const std::vector<std::string_view>& channels, Handler handler, Dropped dropped,
                   size_t max_queued_bytes, const std::vector<std::string_view>& heads)
    : prefix_length_(prefix.size()),
      handler_(std::move(handler)),
      dropped_(std::move(dropped)),
      max_queued_bytes_(max_queued_bytes) {
  std::vector<std::string> names;
  for (const std::string_view channel : channels) names.push_back(prefix + std::string(channel));
  const size_t whole = names.size();
  for (const std::string_view channel : heads) names.push_back(prefix + std::string(channel));
  if (IsUdpm(url)) {
    const auto wanted = [names, whole](std::string_view name) -> size_t {
      for (size_t i = 0; i < names.size(); ++i) {
        if (names[i] != name && names[i] != kAllChannels) continue;
        return i < whole ? DatagramJoiner::kMaxMessageBytes : kHeadBytes;
      }
      return 0;
    };
    udpm_.emplace(url, wanted, heads.empty() && std::ranges::all_of(channels, IsShort));
  } else {
    Subscribe(names, url);
  }
  handling_ = std::jthread([this](const std::stop_token& stop) { Handle(stop); });
  receiving_ = std::jthread([this](const std::stop_token& stop) {
    if (!udpm_) return ReceiveTcpq(stop);
    udpm_->Receive(stop, [this](DatagramJoiner::Message message) {
      Enqueue(message.channel, std::move(message.bytes));
    });
  });
}

bool Receiver::IsBehind() {
  const std::lock_guard lock(mutex_);
  return late_ > 0 || (udpm_ && udpm_->is_behind());
}

void Receiver::Subscribe(const std::vector<std::string>& names, const std::string& url) {
  tcpq_ = OpenLcm(url);
  for (const std::string& name : names) {
    lcm_subscription_t* subscription = lcm_subscribe(tcpq_.get(), name.c_str(), &OnMessage, this);
    if (subscription == nullptr) throw BusError("cannot subscribe to " + name + " on " + url);
    lcm_subscription_set_queue_capacity(subscription, kQueueCapacity);
  }
}

void Receiver::ReceiveTcpq(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    // A tcpq server that hung up leaves no connection; LCM would abort the program on it.
    if (lcm_get_fileno(tcpq_.get()) < 0) {
      if (SleepFor(kReconnectPeriod, stop)) Reconnect();
    } else if (lcm_handle_timeout(tcpq_.get(), kPollMs) < 0) {
      SleepFor(std::chrono::milliseconds(kPollMs), stop);
    }
  }
}

// With tcpq any new subscription connects again first, and renews the existing ones. Nothing is
// ever sent on this channel.
void Receiver::Reconnect() {
  lcm_subscription_t* probe = lcm_subscribe(tcpq_.get(), "SPROUT_RECONNECT", &OnMessage, this);
  if (probe != nullptr) lcm_unsubscribe(tcpq_.get(), probe);
}

void Receiver::OnMessage(const lcm_recv_buf_t* buffer, const char* channel, void* self) {
  auto* receiver = static_cast<Receiver*>(self);
  try {
    MessageBytes bytes = MessageBytes::OfSize(buffer->data_size);
    std::memcpy(bytes.memory.data, buffer->data, buffer->data_size);
    receiver->Enqueue(channel, std::move(bytes));
  } catch (const std::bad_alloc&) {  // must not cross LCM's C frames
    if (receiver->dropped_) {
      receiver->dropped_(std::string_view(channel).substr(receiver->prefix_length_));
    }
  }
}

void Receiver::Enqueue(std::string_view name, MessageBytes bytes) {
  const std::string_view channel = name.substr(prefix_length_);
  const size_t taken = bytes.size() + kOverheadBytes;
  try {
    Message message{.channel = std::string(channel),
                    .bytes = std::move(bytes),
                    .is_late = udpm_ && udpm_->is_behind()};
    const std::lock_guard lock(mutex_);
    if (queued_bytes_ + taken <= max_queued_bytes_) {
      late_ += message.is_late;
      queue_.push_back(std::move(message));
      queued_bytes_ += taken;
      filled_.notify_one();
      return;
    }
  } catch (const std::bad_alloc&) {  // counts as dropped
  }
  if (dropped_) dropped_(channel);
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
    try {
      handler_(message.channel, message.bytes);
    } catch (const std::exception&) {  // out of memory: must not end the process
      if (dropped_) dropped_(message.channel);
    }
    lock.lock();
    late_ -= message.is_late;
  }
}

}  // namespace sprout
