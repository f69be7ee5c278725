#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "common/app/log_limiter.h"
#include "common/frames/frame_index.h"
#include "common/logfile/log_reader.h"
#include "services/view/frame_source.h"
#include "services/view/status_history.h"

namespace sprout::view {

/// Quality of a frame, without ground truth.
struct Quality {
  double value = 0;  ///< 0 (worst) to 1
  std::string why;   ///< its worst figure; may be empty
};

/// The frames of a log. Only the positions of its messages are kept in memory; they are read on
/// demand. Thread-safe.
class LogFile : public FrameSource {
 public:
  /// Begins to read. @param statuses gets the log's statuses.
  /// @param changed  called on another thread when there are more frames.
  /// @throws LogError when the file is not a log.
  LogFile(const std::filesystem::path& path, std::string prefix, StatusHistory& statuses,
          std::function<void()> changed);

  StoredFramePtr Newest() const override;
  StoredFramePtr Get(int64_t key) const override;
  KeyRange keys() const override;
  std::vector<StoredFramePtr> Snapshot() const override { return {}; }

  /// The first frame with this number; nothing when there is none, or not read yet.
  std::optional<int64_t> KeyOf(int64_t seq) const;

  void SetQuality(int64_t key, Quality quality);

  /// Says that no more qualities will come.
  void Settle() { settled_ = true; }

  /// For the time line: {first, last, complete, settled, complaint, buckets: [{key, seq, utime,
  /// quality, why}]}. The worst rated frame of each bucket, or else its first one.
  std::string TimeLineText(int buckets) const;

  /// Share of the log read so far, 0 to 1.
  double progress() const;

  /// What is wrong with the log, in one line; empty: nothing.
  std::string complaint() const;

 private:
  void Read(const std::stop_token& stop);
  void Add(const LogEvent& event);
  StoredBytes Fetch(int64_t offset) const;

  std::filesystem::path path_;
  std::string prefix_;
  StatusHistory& statuses_;
  std::function<void()> changed_;
  LogReader reader_;
  mutable std::mutex fetch_mutex_;
  mutable EventFetcher fetcher_;
  mutable LimitedWarnings unreadable_;
  mutable std::mutex mutex_;
  FrameIndex index_;
  std::map<int64_t, Quality> qualities_;  // by key
  std::string complaint_;
  int64_t refused_ = 0;  // messages
  std::string first_refused_;
  std::atomic<double> progress_ = 0;
  std::atomic<bool> settled_ = false;
  std::jthread thread_;  // last: stops before the rest is destroyed
};

/// The order in which frames are rated: at any time the rated ones are spread evenly, so that a
/// time line covers the whole log from the start and becomes finer. At most `most` of `count`
/// frames.
std::vector<int64_t> SpreadOrder(int64_t count, int64_t most);

/// Rates the frames of a log on its own thread, at low priority, once the log is read. In a long
/// log only a part of the frames, since each takes some hundredths of a second.
class LogQuality {
 public:
  static constexpr int64_t kMaxFrames = 2000;

  /// @param log  must outlive this.
  explicit LogQuality(LogFile& log);

 private:
  void Run(const std::stop_token& stop);

  LogFile& log_;
  std::jthread thread_;
};

}  // namespace sprout::view
