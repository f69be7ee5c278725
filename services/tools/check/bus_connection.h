#ifndef SPROUT_SERVICES_TOOLS_CHECK_BUS_CONNECTION_H_
#define SPROUT_SERVICES_TOOLS_CHECK_BUS_CONNECTION_H_

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/bus/channels.h"
#include "common/bus/publisher.h"
#include "common/bus/receiver.h"

namespace sprout::check {

/// A received message of the graph.
struct Heard {
  std::string channel;
  std::vector<uint8_t> bytes;
  std::chrono::steady_clock::time_point when;
};

/// Sends on the bus, and receives its own messages, too. Not thread-safe.
class BusConnection {
 public:
  /// @param channels  to receive; Receiver::kAllChannels for all.
  /// @throws BusError, see OpenLcm().
  explicit BusConnection(const std::string& url,
                         const std::vector<std::string_view>& channels = AllChannels());

  /// @throws BusError when LCM refuses the message.
  void Send(std::string_view channel, std::span<const uint8_t> bytes);

  /// The next message, in order of arrival; nothing when none comes before `deadline`.
  std::optional<Heard> Next(std::chrono::steady_clock::time_point deadline);

 private:
  std::mutex mutex_;
  std::condition_variable filled_;
  std::deque<Heard> heard_;
  Publisher publisher_;
  Receiver receiver_;  // last: stops before the rest is destroyed
};

}  // namespace sprout::check

#endif  // SPROUT_SERVICES_TOOLS_CHECK_BUS_CONNECTION_H_
