#ifndef SPROUT_COMMON_LOGFILE_NEW_LOG_H_
#define SPROUT_COMMON_LOGFILE_NEW_LOG_H_

#include <filesystem>

#include "common/logfile/log_reader.h"
#include "common/logfile/log_writer.h"

namespace sprout {

/// A log that appears whole or not at all: it grows as `PATH.part` and gets its name with Commit().
/// Without Commit() the part is removed.
class NewLog {
 public:
  /// @param overwrite  whether a file of that name may be replaced; it stays until Commit().
  /// @throws LogError when it may not, or nothing can be written there.
  NewLog(std::filesystem::path path, bool overwrite);
  ~NewLog();
  NewLog(const NewLog&) = delete;
  NewLog& operator=(const NewLog&) = delete;

  /// Adds an event with the time, channel and data of `event`. @throws LogError.
  void Write(const LogEvent& event) { writer_.Write(event.utime, event.channel, event.data); }

  int64_t events() const { return writer_.events(); }

  /// @throws LogError; nothing is left behind then.
  void Commit();

 private:
  std::filesystem::path path_;
  std::filesystem::path part_path_;
  LogWriter writer_;
  bool committed_ = false;
};

}  // namespace sprout

#endif  // SPROUT_COMMON_LOGFILE_NEW_LOG_H_
