#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/logfile/event_finder.h"
#include "common/logfile/file_window.h"
#include "common/logfile/log_error.h"

namespace sprout {

/// One event of a log. Views are valid until the next call of LogReader::Next().
struct LogEvent {
  int64_t number = 0;  ///< the recorder's count
  int64_t utime = 0;   ///< time of recording, µs
  int64_t offset = 0;  ///< byte in the file where the event begins
  std::string_view channel;
  std::span<const uint8_t> data;
};

/// A stretch of bytes without a readable event.
struct LogDamage {
  int64_t offset = 0;  ///< first unreadable byte
  int64_t bytes = 0;   ///< how many were skipped
  bool tail = false;   ///< the file ends inside an event
  /// How many events were lost, by the numbers before and after it; nothing when they do not tell.
  std::optional<int64_t> events;

  bool operator==(const LogDamage&) const = default;
};

/// "64 unreadable bytes at byte 100, skipped", for a line of a log.
std::string SkippedText(const LogDamage& damage);

/// Reads the events of an lcm-logger file in order, in constant memory (the largest event and a
/// megabyte), and continues after damage; EventFinder tells events from damage. liblcm's reader
/// takes a damaged length for the end of the file, or skips good events.
class LogReader {
 public:
  /// @throws LogError when the file cannot be opened or is no LCM log: it has bytes, but no event,
  ///         complete or torn. An empty file is a log without events.
  explicit LogReader(const std::filesystem::path& path);

  /// @returns false at the end of the file.
  /// @throws LogError when reading fails.
  bool Next(LogEvent& event);

  /// Damage found so far, in order of the file.
  const std::vector<LogDamage>& damage() const { return damage_; }

  int64_t size() const { return file_.size(); }   ///< bytes of the file
  int64_t position() const { return position_; }  ///< bytes read so far, for progress lines

 private:
  std::optional<EventPosition> FindNext();
  void Trust(const EventPosition& event);
  void Skip(const std::optional<EventPosition>& next);

  InputFile file_;
  FileWindow window_;
  EventFinder finder_;
  int64_t position_ = 0;
  std::optional<EventPosition> last_;     // the event read last
  std::optional<EventPosition> trusted_;  // the last one whose number is confirmed by another
  std::optional<EventPosition> ahead_;    // the next one, if already found
  std::vector<LogDamage> damage_;
};

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
