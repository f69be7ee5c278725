#ifndef SPROUT_SERVICES_RECORD_RECORDING_FILE_H_
#define SPROUT_SERVICES_RECORD_RECORDING_FILE_H_

#include <cstdint>
#include <filesystem>

#include "common/logfile/log_error.h"
#include "services/record/recorded_event.h"

namespace sprout::record {

/// An LCM log that is readable up to its last whole event at any time, whatever happens to this
/// process or to the disk. That is the opposite of LogWriter, whose log appears whole or not at
/// all: a recording cannot be made again. So it has its name from the start, nothing waits in a
/// buffer of ours, and an event that was written in part is cut off.
class RecordingFile {
 public:
  /// @throws LogError when the file cannot be made; one of that name is never touched.
  explicit RecordingFile(std::filesystem::path path);
  ~RecordingFile();
  RecordingFile(const RecordingFile&) = delete;
  RecordingFile& operator=(const RecordingFile&) = delete;

  /// @throws LogError when the disk is full or the like; the file then ends with the event before.
  void Write(const RecordedEvent& event);

  /// Waits until all is on the disk. @throws LogError.
  void Close();

  /// Whether the path still leads to this file: who deletes the folder or takes the disk away makes
  /// no write fail.
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
