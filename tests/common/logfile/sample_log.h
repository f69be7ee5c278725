#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <ostream>
#include <string>
#include <vector>

#include "common/logfile/log_reader.h"
#include "common/logfile/log_writer.h"
#include "tests/common/picture/temporary_directory.h"

namespace sprout {

using Bytes = std::vector<uint8_t>;

/// A LogEvent that owns what it shows.
struct Event {
  int64_t number = 0;
  int64_t utime = 0;
  int64_t offset = 0;
  std::string channel;
  Bytes data;

  int64_t end() const { return offset + 28 + static_cast<int64_t>(channel.size() + data.size()); }
  bool operator==(const Event&) const = default;
};

inline void PrintTo(const Event& event, std::ostream* out) {
  *out << "event " << event.number << " at byte " << event.offset << ", " << event.channel << ", "
       << event.data.size() << " bytes";
}

inline Bytes ReadBytes(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return Bytes(std::istreambuf_iterator<char>(file), {});
}

inline void WriteBytes(const std::filesystem::path& path, const Bytes& bytes) {
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
}

struct LogContent {
  std::vector<Event> events;
  std::vector<LogDamage> damage;
};

inline LogContent ReadLog(const std::filesystem::path& path) {
  LogReader reader(path);
  LogContent content;
  for (LogEvent event; reader.Next(event);) {
    content.events.push_back({event.number, event.utime, event.offset, std::string(event.channel),
                              Bytes(event.data.begin(), event.data.end())});
  }
  content.damage = reader.damage();
  return content;
}

inline LogContent ReadLog(const Bytes& bytes) {
  const TemporaryDirectory folder;
  WriteBytes(folder / "log", bytes);
  return ReadLog(folder / "log");
}

/// Bytes of a log of these events; their numbers and offsets are set on the way.
inline Bytes MakeLog(std::vector<Event>& events) {
  const TemporaryDirectory folder;
  LogWriter writer(folder / "log");
  int64_t offset = 0;
  for (Event& event : events) {
    event.number = writer.events();
    event.offset = offset;
    offset = event.end();
    writer.Write(event.utime, event.channel, event.data);
  }
  writer.Close();
  return ReadBytes(folder / "log");
}

/// Payloads of different lengths, one of them empty, one with sync words; channels of different
/// lengths.
inline std::vector<Event> SampleEvents(int count) {
  std::vector<Event> events;
  for (int i = 0; i < count; ++i) {
    Event event;
    event.utime = 1'700'000'000'000'000 + 33'333 * i;
    event.channel = std::string("SPROUT_") + std::string(static_cast<size_t>(i % 5), 'X');
    for (int k = 0; k < 37 * i % 211; ++k) {
      constexpr uint8_t kSync[] = {0xED, 0xA1, 0xDA, 0x01};
      event.data.push_back(i % 7 == 3 ? kSync[k % 4] : static_cast<uint8_t>(i + k));
    }
    events.push_back(event);
  }
  return events;
}

}  // namespace sprout
