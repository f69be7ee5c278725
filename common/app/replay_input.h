#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "common/config/frame_range.h"
#include "common/logfile/channel_counts.h"
#include "common/logfile/log_reader.h"

namespace sprout {

/// The events of one or more logs as one stream in order of time, damage skipped and logged.
///
/// Events of one log keep their order: an event older than one before it counts as equally old.
/// Events of equal times come in the order of the logs. A channel that several logs have is taken
/// from the last of them, so that a replay's answers replace recorded ones. Constant memory: one
/// event a log. Logs after the first are read twice.
class ReplayInput {
 public:
  /// @param logs      paths, at least one.
  /// @param shared    a channel that is read from all logs that have it; empty: none.
  /// @param ordering  the channels whose times order the logs. Events of other channels follow at
  ///                  once after the events before them in their log, so that unused channels do
  ///                  not change the order. Empty: all.
  /// @throws LogError when one cannot be opened or is no log.
  explicit ReplayInput(const std::vector<std::string>& logs, std::string_view shared = {},
                       std::set<std::string, std::less<>> ordering = {});

  /// @returns false at the end of all logs. Views in `event` are valid until the next call.
  /// @throws LogError when reading fails.
  bool Next(LogEvent& event);

  int64_t events() const { return events_; }  ///< read so far
  int64_t damaged_bytes() const { return damaged_bytes_; }

  const ChannelCounts& channels() const { return channels_; }  ///< read so far

  /// What was left out so far of frames all before, or all behind those that were read by utime or
  /// by number, as of two parts of one recording, or all with other calibrations, as of two rigs;
  /// and of logs of which nothing is used, as of answers that are named before the recording. Of
  /// the ordering channels with frames; one line a log.
  std::vector<std::string> LeftOut() const;

  /// Share of the bytes read so far, 0 to 1.
  double progress() const;

 private:
  // Messages of frames: from the earliest to the latest capture, from the smallest number to the
  // largest. Behind a step of the clock only the numbers tell what is later.
  struct Span {
    int64_t messages = 0;
    int64_t first_utime = 0;
    int64_t last_utime = 0;
    FrameRange numbers;
    std::set<std::string> rigs = {};  // rig_id of the frames; at most kMaxRigs
  };
  using Spans = std::map<std::string, Span, std::less<>>;  // by channel

  struct Log {
    std::string path;
    std::unique_ptr<LogReader> reader;
    std::set<std::string, std::less<>> hidden;           // channels that a later log has
    Spans left_out;                                      // on those
    bool is_used = false;                                // one of its ordering events was given
    std::optional<LogEvent> head;                        // next event
    int64_t time = std::numeric_limits<int64_t>::min();  // of the newest so far, head included
    size_t damage_seen = 0;
  };

  static constexpr size_t kMaxRigs = 16;

  static bool AreOthers(const Span& left_out, const Span& read);
  void Advance(Log& log);
  void Note(const LogEvent& event, Spans& spans) const;
  void ReportDamage(Log& log);

  std::set<std::string, std::less<>> ordering_;
  std::vector<Log> logs_;
  Log* taken_ = nullptr;  // whose head the caller has
  Spans read_;
  ChannelCounts channels_;
  int64_t events_ = 0;
  int64_t damaged_bytes_ = 0;
};

}  // namespace sprout
