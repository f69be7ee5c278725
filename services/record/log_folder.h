#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>

#include "common/logfile/log_error.h"
#include "services/record/event_ring.h"

namespace sprout::record {

/// An LCM log that is readable up to its last whole event at any time, whatever happens to this
/// process or to the disk. Unlike LogWriter, whose log is complete or not there: a recording cannot
/// be repeated. So it has its final name from the start, nothing waits in a buffer of this process,
/// and a partly written event is cut off.
class RecordingFile {
 public:
  /// @throws LogError when the file cannot be created; an existing file is never changed.
  explicit RecordingFile(std::filesystem::path path);
  ~RecordingFile();
  RecordingFile(const RecordingFile&) = delete;
  RecordingFile& operator=(const RecordingFile&) = delete;

  /// @throws LogError when writing fails, for instance on a full disk; the file then ends with the
  ///         previous event.
  void Write(const RecordedEvent& event);

  /// Waits until everything is on the disk. @throws LogError.
  void Close();

  /// Whether the path still leads to this file: deleting the folder or removing the disk makes no
  /// write fail.
  bool IsThere() const;

  /// Bytes that an event takes in a log.
  static int64_t BytesOf(const RecordedEvent& event);

  const std::filesystem::path& path() const { return path_; }
  int64_t bytes() const { return bytes_; }    ///< written so far
  int64_t events() const { return events_; }  ///< written so far

 private:
  [[noreturn]] void Fail(int error) const;

  std::filesystem::path path_;
  int descriptor_;
  int64_t bytes_ = 0;
  int64_t events_ = 0;
};

struct LogFolderOptions {
  std::filesystem::path folder;
  int64_t max_file_bytes = 0;  ///< largest log; then the next one begins
  int64_t quota_bytes = 0;     ///< largest size of the folder, other files included
  bool delete_oldest = false;  ///< delete the oldest recordings instead of stopping at the quota
};

/// The logs of a folder, record_NUMBER_DATE_TIME.lcm. Numbers continue from the largest existing
/// one, so they order the recordings even if the clock was wrong. Not thread-safe.
class LogFolder {
 public:
  using LastEvent = std::function<RecordedEvent()>;

  /// Creates the folder if missing, and locks it for the life of this object.
  /// @param last_event  gives the last event of every log: the losses so far.
  /// @throws ConfigError when the folder is not writable, or another process records there.
  LogFolder(LogFolderOptions options, LastEvent last_event);
  ~LogFolder();
  LogFolder(const LogFolder&) = delete;
  LogFolder& operator=(const LogFolder&) = delete;

  /// Appends to the open log; begins one if there is none or it is full.
  /// @throws LogError when it cannot be written or the quota is reached. The log stays open and is
  ///         intact up to the previous event.
  void Write(const RecordedEvent& event);

  /// Ends the open log, if there is one, with the last event.
  /// @throws LogError; the log is closed then, too.
  void Close();

  /// @throws LogError when the folder or the open log has vanished.
  void RequireThere() const;

  bool is_open() const { return file_ != nullptr; }
  /// Path of the open log.
  const std::filesystem::path& path() const { return file_->path(); }

  int64_t files() const { return files_; }      ///< logs begun so far
  int64_t events() const { return events_; }    ///< written so far
  int64_t bytes() const { return bytes_; }      ///< written so far
  int64_t deleted() const { return deleted_; }  ///< logs deleted so far

 private:
  void Append(const RecordedEvent& event);
  void Open(int64_t utime);
  void MakeRoom(int64_t bytes);
  bool DeleteOldest();

  LogFolderOptions options_;
  LastEvent last_event_;
  int lock_;
  int64_t next_number_ = 1;
  int64_t held_bytes_ = 0;  // in the folder, measured with each new log
  std::unique_ptr<RecordingFile> file_;
  int64_t files_ = 0;
  int64_t events_ = 0;
  int64_t bytes_ = 0;
  int64_t deleted_ = 0;
};

/// Number in the name of a log of a LogFolder; nothing for other files.
std::optional<int64_t> RecordingNumber(const std::filesystem::path& path);

}  // namespace sprout::record
