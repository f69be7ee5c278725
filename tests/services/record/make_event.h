#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/logfile/log_reader.h"
#include "services/record/event_ring.h"

namespace sprout::record {

/// A message that came at that time, as its utime says, too.
inline RecordedEvent MakeRecorded(double seconds, size_t data_bytes = 100,
                                  const std::string& channel = "A") {
  const std::chrono::microseconds time(static_cast<int64_t>(seconds * 1e6));
  return {.utime = time.count(),
          .arrived = RecordedEvent::Clock::time_point(time),
          .channel = channel,
          .data = std::vector<uint8_t>(data_bytes, 7)};
}

struct LogContent {
  std::vector<double> seconds;
  std::vector<std::string> channels;
};

inline LogContent ReadLog(const std::filesystem::path& path) {
  LogContent content;
  LogReader reader(path);
  LogEvent event;
  while (reader.Next(event)) {
    content.seconds.push_back(static_cast<double>(event.utime) / 1e6);
    content.channels.emplace_back(event.channel);
  }
  return content;
}

}  // namespace sprout::record
