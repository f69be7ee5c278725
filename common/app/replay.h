#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "common/app/service_context.h"
#include "common/core/stage_adapter.h"
#include "common/logfile/channel_counts.h"
#include "common/logfile/log_reader.h"

namespace sprout {

/// Most unfinished frames of a replay: in a log of a graph that lags far behind its capture the
/// last message of a frame comes long after the first. Live there are fewer, to save memory.
inline constexpr size_t kReplayMaxPending = 64;

/// Runs an adapter on logs, on this thread and without a network: every event in order, no frame
/// skipped. Its answers become the events of `options.record`, with the time of the event that
/// completed their frame. No clock is used, so the same logs give the same bytes. Reports on
/// stderr, and in one line of counts on stdout.
///
/// The first calibration of the logs holds from their start: a stage that ran live knew it before
/// the recording began, while in the log it may come a second late.
///
/// A stage with memory also gets the frames before `options.frames` that it needs to warm up
/// (StageAdapter::WarmUpFrames()); their answers are not recorded.
///
/// The log appears when it is complete, or context.stop ends the run early; until then an older log
/// of that name stays.
///
/// @returns exit code: 0; 1 when the written log is incomplete: stopped, damage or bad messages in
///          a log, or a frame on which the adapter failed; 1 also when all frames are degenerate.
/// @throws ConfigError, and leaves nothing behind, when a log cannot be used, has no frame to
///         process, or is also the output; LogError when writing fails.
int RunReplay(const ServiceContext& context, const ReplayOptions& options, StageAdapter& adapter);

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

  /// Share of the bytes read so far, 0 to 1.
  double progress() const;

 private:
  struct Log {
    std::string path;
    std::unique_ptr<LogReader> reader;
    std::set<std::string, std::less<>> hidden;           // channels that a later log has
    std::optional<LogEvent> head;                        // next event
    int64_t time = std::numeric_limits<int64_t>::min();  // of the newest so far, head included
    size_t damage_seen = 0;
  };

  void Advance(Log& log);
  void ReportDamage(Log& log);

  std::set<std::string, std::less<>> ordering_;
  std::vector<Log> logs_;
  Log* taken_ = nullptr;  // whose head the caller has
  ChannelCounts channels_;
  int64_t events_ = 0;
  int64_t damaged_bytes_ = 0;
};

}  // namespace sprout
