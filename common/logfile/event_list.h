#ifndef SPROUT_COMMON_LOGFILE_EVENT_LIST_H_
#define SPROUT_COMMON_LOGFILE_EVENT_LIST_H_

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/logfile/event_fetcher.h"

namespace sprout {

/// Some events of a log, with times of their own: a part of a log without a copy of it. LogReader
/// reads a list as if it were a log of these events.
///
/// A list is text: "SPROUT_EVENTS " and the path of the log, then "OFFSET UTIME" a line. Only
/// /dev/fd/N can be one, which the program was started with; so no file that came from elsewhere
/// makes a program read another one.
class EventList {
 public:
  /// What begins a list.
  static constexpr std::string_view kMagic = "SPROUT_EVENTS ";

  /// An event of the log.
  struct Entry {
    int64_t offset = 0;
    int64_t utime = 0;
  };

  static std::string Text(const std::filesystem::path& log, const std::vector<Entry>& entries);

  /// @returns nothing when the file is no list. @throws LogError when its log cannot be opened, or
  ///          the list is damaged.
  static std::unique_ptr<EventList> Open(const InputFile& file);

  /// As LogReader::Next().
  bool Next(LogEvent& event);

  /// Share of the entries read so far.
  double progress() const {
    return entries_.empty() ? 1 : static_cast<double>(next_) / static_cast<double>(entries_.size());
  }

 private:
  EventList(const std::filesystem::path& log, std::vector<Entry> entries)
      : fetcher_(log), entries_(std::move(entries)) {}

  EventFetcher fetcher_;
  std::vector<Entry> entries_;
  size_t next_ = 0;
};

}  // namespace sprout

#endif  // SPROUT_COMMON_LOGFILE_EVENT_LIST_H_
