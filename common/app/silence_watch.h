#ifndef SPROUT_COMMON_APP_SILENCE_WATCH_H_
#define SPROUT_COMMON_APP_SILENCE_WATCH_H_

#include <chrono>
#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "common/app/service_context.h"
#include "common/app/stage_monitor.h"

namespace sprout {

/// Messages received, by channel.
using MessageCounts = std::map<std::string, int64_t>;

/// Why no frame came, in one line: which channels are missing, and which ones have messages.
/// @param needed   channels that make a frame, with prefix.
/// @param counts   of these, since the last whole frame. @param present of all channels, during a
///                 short time.
std::string SilenceText(const std::vector<std::string>& needed, const MessageCounts& counts,
                        const MessageCounts& present);

/// When a stage gets no complete frame for kPatience, listens to all channels for a second and
/// warns once; the warning is over with the next complete frame. Thread-safe.
class SilenceWatch {
 public:
  static constexpr std::chrono::seconds kPatience{5};

  /// @param channels  that make a frame, without prefix.
  /// @param monitor   gets the warnings.
  /// @param patience  shorter in tests.
  SilenceWatch(const ServiceContext& context, std::vector<std::string_view> channels,
               StageMonitor& monitor, std::chrono::milliseconds patience = kPatience);

  /// A message came on one of the channels.
  void Heard(std::string_view channel);

  /// A whole frame came.
  void HeardFrame();

 private:
  using Clock = std::chrono::steady_clock;

  void Watch(const std::stop_token& stop);
  void Warn();

  std::string url_;
  std::vector<std::string> needed_;  // with prefix
  size_t prefix_length_;
  StageMonitor& monitor_;
  std::chrono::milliseconds patience_;
  std::mutex mutex_;
  MessageCounts counts_;
  Clock::time_point last_frame_ = Clock::now();
  bool warned_ = false;
  std::string warning_;  // that holds now
  std::jthread thread_;  // last: stops before the rest is destroyed
};

}  // namespace sprout

#endif  // SPROUT_COMMON_APP_SILENCE_WATCH_H_
