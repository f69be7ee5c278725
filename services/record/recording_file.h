#ifndef SPROUT_SERVICES_RECORD_RECORDING_FILE_H_
#define SPROUT_SERVICES_RECORD_RECORDING_FILE_H_

#include <cstdint>
#include <filesystem>

#include "common/logfile/log_error.h"
#include "services/record/recorded_event.h"

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

}  // namespace sprout::record

#endif  // SPROUT_SERVICES_RECORD_RECORDING_FILE_H_
