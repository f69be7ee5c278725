#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "common/app/status_board.h"
#include "common/core/stage_status.h"

namespace sprout::view {

/// Keeps the newest status of every process, as sprout-top does, and for the plots the last minutes
/// of every stage. Thread-safe.
class StatusHistory {
 public:
  /// Most samples of a stage. In a log, which may have more, every second one is dropped when it is
  /// full.
  static constexpr size_t kMaxSamples = 900;

  /// @param expected   stages that must be there.
  /// @param keep_all   thin out old samples (a log), instead of dropping them (a running graph).
  StatusHistory(std::vector<std::string> expected, bool keep_all)
      : board_(std::move(expected)), keep_all_(keep_all) {}

  /// @param utime  arrival, µs.
  void Add(const StageStatus& status, int64_t utime, StatusBoard::Clock::time_point now);

  /// The board, see BoardJson().
  std::string BoardText(StatusBoard::Clock::time_point now) const;

  /// {stage: {t, rate_hz, age_p50_ms, age_p99_ms, lost, bad, rss_mb}}: arrays of equal length, t in
  /// s since 1970; lost and bad are counts since the start of the process.
  std::string HistoryText() const;

  /// Arrival of the newest status, as given to Add().
  StatusBoard::Clock::time_point newest() const;

 private:
  struct Sample {
    int64_t utime;
    int64_t seen;  // number of statuses that came before
    StageStatus status;
  };
  struct Samples {
    std::deque<Sample> samples;
    int64_t seen = 0;
    int64_t step = 1;
  };

  mutable std::mutex mutex_;
  StatusBoard board_;
  bool keep_all_;
  StatusBoard::Clock::time_point newest_{};
  std::map<std::string, Samples> samples_;
};

}  // namespace sprout::view
