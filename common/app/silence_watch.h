#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "common/app/service_context.h"
#include "common/app/stage_monitor.h"

namespace sprout {

/// Messages received, by channel.
using MessageCounts = std::map<std::string, int64_t>;

/// Why no whole frame came, in one line: which channels are missing, and which ones have messages.
/// @param needed   channels that make a frame, with prefix.
/// @param counts   of these, since the last whole frame. @param present of all channels, during a
///                 short time.
/// @param begun    as present, but also messages that did not come whole.
std::string SilenceText(const std::vector<std::string>& needed, const MessageCounts& counts,
                        const MessageCounts& present, const MessageCounts& begun = {});

/// When a stage gets no complete frame for kPatience, or for three times the last interval between
/// two of them (one minute at most), listens to all channels for a second and warns, again
/// when another of its channels is heard; the warning is over with the next complete frame.
/// Thread-safe.
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

  /// A whole frame came, or whatever else is waited for.
  void HeardFrame();

  /// In place of both for those who take single messages: once each channel has been heard, every
  /// message is what is waited for.
  void HeardSingle(std::string_view channel);

 private:
  using Clock = std::chrono::steady_clock;

  void Watch(const std::stop_token& stop);
  void Warn(const std::stop_token& stop);

  std::string url_;
  std::vector<std::string> needed_;  // with prefix
  size_t prefix_length_;
  StageMonitor& monitor_;
  std::chrono::milliseconds patience_;
  std::mutex mutex_;
  Clock::duration wait_;  // for the next frame
  bool heard_frame_ = false;
  MessageCounts counts_;
  std::set<std::string, std::less<>> singles_;  // channels of HeardSingle()
  Clock::time_point last_frame_ = Clock::now();
  bool warned_ = false;
  size_t told_ = 0;  // channels heard when it warned, and when that was
  Clock::time_point told_at_;
  std::vector<std::string> warnings_;  // that hold now, at most one a channel
  std::jthread thread_;                // last: stops before the rest is destroyed
};

/// Warns of other processes of the same stage on the same channels, once each; the warning is over
/// when the other one has ended, or has been silent for kSilentFor. Not thread-safe.
class DuplicateWatch {
 public:
  using Clock = std::chrono::steady_clock;

  /// Statuses come once a second.
  static constexpr std::chrono::seconds kSilentFor{5};

  /// @param monitor  knows the name of this process, and gets the warnings.
  /// @param now      returns the time; tests replace it.
  explicit DuplicateWatch(StageMonitor& monitor,
                          std::function<Clock::time_point()> now = Clock::now)
      : monitor_(monitor), now_(std::move(now)) {}

  /// A status of any process came, also of this one.
  void Heard(const StageStatus& status);

 private:
  struct Twin {
    std::string warning;
    Clock::time_point heard;
  };

  void ForgetSilentOnes();

  StageMonitor& monitor_;
  std::function<Clock::time_point()> now_;
  std::map<std::pair<std::string, int32_t>, Twin> twins_;  // by host and process
};

}  // namespace sprout
