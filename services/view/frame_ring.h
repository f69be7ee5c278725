#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/core/result.h"
#include "services/view/frame_source.h"

namespace sprout::view {

/// The newest frames of the running graph, and every message that came with them, so that the last
/// seconds can be saved as a log. Thread-safe.
///
/// A frame is shown once it has every part that the graph currently gives, so that all pictures are
/// of one frame, even when stages start, end or are replaced.
class FrameRing : public FrameSource {
 public:
  using Clock = std::chrono::steady_clock;

  static constexpr size_t kMaxFrames = 100;

  /// @param max_bytes  of messages; beyond it the oldest frames are dropped, but never the newest
  ///                   one.
  explicit FrameRing(size_t max_bytes) : max_bytes_(max_bytes) {}

  /// Takes one message.
  /// @param channel  without prefix.
  /// @param utime    arrival, µs, for the log.
  /// @returns whether Newest() is another frame now, or has more parts; an error for a message of
  ///          the wrong type for its channel. The content is decoded only when it is shown.
  Result<bool> Add(std::string_view channel, std::span<const uint8_t> bytes, int64_t utime,
                   Clock::time_point now);

  StoredFramePtr Newest() const override;
  StoredFramePtr Get(int64_t key) const override;
  KeyRange keys() const override;
  std::vector<StoredFramePtr> Snapshot() const override;

  size_t bytes() const;

  /// Whether frames were dropped for lack of memory before there were kMaxFrames.
  bool is_short() const;

  /// Writes the messages of the last `seconds` as an LCM log, with `prefix` before the channels.
  /// @returns how many messages it has. @throws LogError.
  int64_t WriteLog(const std::filesystem::path& path, const std::string& prefix,
                   double seconds) const;

 private:
  struct Event {
    int64_t utime;
    std::string channel;
    StoredBytes bytes;
  };

  // How often a part comes, to know whether a frame without it may still get it.
  struct Pace {
    std::optional<Clock::time_point> last;
    Clock::duration interval{};
  };

  void AddRig(const FrameId& id, const StoredBytes& bytes);
  StoredFramePtr& FindOrStart(const FrameId& id);
  bool IsComplete(const StoredFrame& frame, Clock::time_point now) const;
  bool IsExpected(Part part, Clock::time_point now) const;
  bool Announce(const StoredFramePtr& frame, Clock::time_point now);
  void Forget();
  void DropFrontEvent();

  const size_t max_bytes_;
  mutable std::mutex mutex_;
  std::deque<Event> events_;  // in order of arrival
  size_t event_bytes_ = 0;
  int64_t dropped_events_ = 0;         // number of the first of events_, since the start
  std::deque<StoredFramePtr> frames_;  // by key, without gaps
  std::deque<int64_t> started_;        // number of the first event of each frame, since the start
  std::deque<std::pair<std::string, StoredBytes>> rigs_;  // by rig_id, the newest few
  std::array<Pace, kPartCount> paces_;
  StoredFramePtr newest_;
  Clock::time_point newest_since_{};
  int64_t next_key_ = 0;
  bool short_ = false;
};

}  // namespace sprout::view
