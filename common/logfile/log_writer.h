#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string_view>

#include "common/core/output_file.h"
#include "common/logfile/log_error.h"

namespace sprout {

/// Writes an event log that every LCM tool reads. Events are numbered 0, 1, ... as lcm-logger does,
/// unless a number is given.
/// The log is complete or not there, see OutputFile; programs that read an older one meanwhile are
/// not disturbed.
class LogWriter {
 public:
  /// @param overwrite  whether a file of that name may be replaced.
  /// @param over_input  whether also one that this program reads, as with sprout-log's --force.
  /// @throws LogError when the file exists and may not be replaced, or cannot be written.
  explicit LogWriter(const std::filesystem::path& path, bool overwrite = true,
                     OutputFile::OverInput over_input = OutputFile::OverInput::kRefused);

  /// @param channel  1 to 63 characters.
  /// @param number   nothing: how many were written before.
  /// @throws LogError when writing fails, for instance on a full disk.
  void Write(int64_t utime, std::string_view channel, std::span<const uint8_t> data,
             std::optional<int64_t> number = std::nullopt);

  /// Writes the rest and gives the log its name. Without this call there is no log.
  /// @throws LogError; nothing is left behind then.
  void Close();

  int64_t events() const { return events_; }  ///< written so far

 private:
  void RequireNoFailure() const;

  std::filesystem::path path_;
  OutputFile file_;
  int64_t events_ = 0;
};

}  // namespace sprout
