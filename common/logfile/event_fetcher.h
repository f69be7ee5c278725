#pragma once

#include <cstdint>
#include <filesystem>

#include "common/logfile/file_window.h"
#include "common/logfile/log_reader.h"

namespace sprout {

/// Reads single events of a log again, in any order.
class EventFetcher {
 public:
  /// @throws LogError when the file cannot be opened.
  explicit EventFetcher(const std::filesystem::path& path);

  /// The event that LogReader found at `offset`; its views are valid until the next call.
  /// @throws LogError when it no longer exists.
  LogEvent Fetch(int64_t offset);

 private:
  InputFile file_;
  FileWindow window_;
};

}  // namespace sprout
