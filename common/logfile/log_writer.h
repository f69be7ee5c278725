#ifndef SPROUT_COMMON_LOGFILE_LOG_WRITER_H_
#define SPROUT_COMMON_LOGFILE_LOG_WRITER_H_

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <span>
#include <string_view>

#include "common/logfile/log_error.h"

namespace sprout {

/// Writes an event log that every LCM tool reads. Events are numbered 0, 1, ... as lcm-logger does.
class LogWriter {
 public:
  /// Overwrites an older file.
  /// @throws LogError when the file cannot be created, or a LogReader or LogWriter, of this or of
  ///         another process, has it open: it would lose what it reads. The file stays as it is
  ///         then. Locks that the file system does not know do not protect it.
  explicit LogWriter(const std::filesystem::path& path);
  ~LogWriter();
  LogWriter(const LogWriter&) = delete;
  LogWriter& operator=(const LogWriter&) = delete;

  /// @param channel  1 to 63 characters.
  /// @throws LogError when the disk is full or the like.
  void Write(int64_t utime, std::string_view channel, std::span<const uint8_t> data);

  /// Flushes and closes. @throws LogError. The destructor closes without a word.
  void Close();

  int64_t events() const { return events_; }  ///< written so far

 private:
  void Put(const void* bytes, size_t count);

  std::filesystem::path path_;
  std::FILE* file_ = nullptr;
  int64_t events_ = 0;
};

}  // namespace sprout

#endif  // SPROUT_COMMON_LOGFILE_LOG_WRITER_H_
