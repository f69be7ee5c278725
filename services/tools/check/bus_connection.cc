#include "services/tools/check/bus_connection.h"

namespace sprout::check {

BusConnection::BusConnection(const std::string& url, const std::vector<std::string_view>& channels)
    : publisher_(url, ""),
      receiver_(url, "", channels,
                [this](std::string_view channel, std::span<const uint8_t> bytes) {
                  const auto now = std::chrono::steady_clock::now();
                  {
                    const std::lock_guard lock(mutex_);
                    heard_.push_back({std::string(channel), {bytes.begin(), bytes.end()}, now});
                  }
                  filled_.notify_one();
                }) {}

void BusConnection::Send(std::string_view channel, std::span<const uint8_t> bytes) {
  if (!publisher_.Publish(channel, bytes)) {
    throw BusError(std::string(channel) + ": could not be published");
  }
}

std::optional<Heard> BusConnection::Next(std::chrono::steady_clock::time_point deadline) {
  std::unique_lock lock(mutex_);
  if (!filled_.wait_until(lock, deadline, [this] { return !heard_.empty(); })) return std::nullopt;
  Heard first = std::move(heard_.front());
  heard_.pop_front();
  return first;
}

}  // namespace sprout::check
