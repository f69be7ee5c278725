#include "services/batch/log_index.h"

#include <fmt/core.h>
#include <sys/stat.h>

#include <charconv>
#include <nlohmann/json.hpp>

#include "common/bus/channels.h"
#include "common/config/config.h"
#include "common/core/digest.h"
#include "common/core/interrupt.h"
#include "common/logfile/event_format.h"
#include "common/logfile/file_window.h"
#include "common/logfile/log_reader.h"
#include "common/messages/codec.h"
#include "common/messages/message_type.h"
#include "services/batch/json_fields.h"
#include "services/batch/text_file.h"

namespace sprout::batch {
namespace {

namespace fs = std::filesystem;

constexpr int kIndexFormat = 3;
constexpr int64_t kMaxLine = 512;  // channel 63, rig_id and seven numbers; longer ids are refused
constexpr size_t kMaxRigId = 128;

std::string_view AsText(std::span<const uint8_t> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

bool IsWord(std::string_view text) {
  return !text.empty() && text.size() <= kMaxRigId &&
         text.find_first_of(" \t\r\n") == std::string_view::npos;
}

// Whether a channel would be one of the graph's, with whatever prefix.
bool NamesPart(std::string_view channel) {
  for (const Part part : kAllParts) {
    if (channel.ends_with(ChannelOf(part))) return true;
  }
  return false;
}

// The event as the index has it; nothing when no stage could use it.
std::optional<IndexedEvent> Describe(const LogEvent& event) {
  const auto type = TypeOf(event.data);
  if (!type || *type == MessageType::kStatus || *type == MessageType::kRigChange ||
      !IsWord(event.channel)) {
    return std::nullopt;
  }
  auto id = DecodeFrameId(event.data);
  if (!id || !IsWord(id->rig_id)) return std::nullopt;
  if (*type == MessageType::kRig && !DecodePart(Part::kRig, event.data)) return std::nullopt;
  return IndexedEvent{.line = 0,
                      .line_end = 0,
                      .offset = event.offset,
                      .bytes = kHeaderBytes + std::ssize(event.channel) + std::ssize(event.data),
                      .utime = event.utime,
                      .channel = std::string(event.channel),
                      .id = std::move(*id),
                      .hash = Hash(AsText(event.data))};
}

// What the first line says of the others.
struct IndexHead {
  IndexSummary summary;
  int64_t bytes = 0;  // of all other lines
  std::string digest;
};

std::string HeadLine(const IndexHead& of) {
  nlohmann::json head = ToJson(of.summary);
  head["sprout_index"] = kIndexFormat;
  head["lines_bytes"] = of.bytes;
  head["lines_digest"] = of.digest;
  return head.dump() + "\n";
}

IndexHead ParseHead(const fs::path& path, std::string_view line) {
  try {
    const auto head = ParseObject(std::string(line));
    if (head.value("sprout_index", nlohmann::json()) == kIndexFormat) {
      return {.summary = IndexSummaryFrom(head),
              .bytes = CountIn(head, "lines_bytes"),
              .digest = DigestIn(head, "lines_digest")};
    }
  } catch (const ConfigError& e) {
    throw LogError(path, e.what());
  }
  throw LogError(path, "not an index of this version");
}

std::string LineOf(const IndexedEvent& event) {
  return fmt::format("{} {} {} {} {} {} {} {:x}\n", event.offset, event.bytes, event.utime,
                     event.channel, event.id.seq, event.id.utime, event.id.rig_id, event.hash);
}

// Takes words off a line.
class Words {
 public:
  Words(const fs::path& path, std::string_view line) : path_(path), rest_(line) {}

  std::string_view Text() {
    const size_t end = std::min(rest_.find(' '), rest_.size());
    const std::string_view word = rest_.substr(0, end);
    rest_.remove_prefix(std::min(end + 1, rest_.size()));
    return word;
  }

  template <typename T>
  T Number(int base = 10) {
    const std::string_view word = Text();
    T number{};
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number, base);
    if (error != std::errc() || end != word.data() + word.size()) {
      throw LogError(path_, "a line of the index is damaged");
    }
    return number;
  }

 private:
  const fs::path& path_;
  std::string_view rest_;
};

IndexedEvent ParseLine(const fs::path& path, int64_t place, std::string_view line) {
  Words words(path, line);
  IndexedEvent event;
  event.line = place;
  event.line_end = place + std::ssize(line) + 1;
  event.offset = words.Number<int64_t>();
  event.bytes = words.Number<int64_t>();
  event.utime = words.Number<int64_t>();
  event.channel = words.Text();
  event.id.seq = words.Number<int64_t>();
  event.id.utime = words.Number<int64_t>();
  event.id.rig_id = words.Text();
  event.hash = words.Number<uint64_t>(16);
  for (const int64_t number : {event.offset, event.bytes}) {
    if (number < 0 || number > kMostOfAnything) {
      throw LogError(path, "a line of the index has an impossible position or size");
    }
  }
  return event;
}

// Every line of `text`, which begins at byte `begin` of the file.
std::vector<IndexedEvent> ParseLines(const fs::path& path, int64_t begin, std::string_view text) {
  std::vector<IndexedEvent> events;
  for (size_t at = 0; at < text.size();) {
    const size_t end = text.find('\n', at);
    if (end == std::string_view::npos) throw LogError(path, "the index ends inside a line");
    events.push_back(ParseLine(path, begin + static_cast<int64_t>(at), text.substr(at, end - at)));
    at = end + 1;
  }
  return events;
}

struct Scan {
  IndexSummary summary;
  std::vector<IndexedEvent> events;
};

Scan ScanLog(const fs::path& log) {
  Scan scan;
  scan.summary.stamp = StampOf(log);
  LogReader reader(log);
  int64_t newest_undecodable = std::numeric_limits<int64_t>::min();
  for (LogEvent event; reader.Next(event);) {
    Interrupt::Check();
    if (auto indexed = Describe(event)) {
      scan.summary.cuttable &= event.utime >= newest_undecodable;
      scan.events.push_back(std::move(*indexed));
    } else if (NamesPart(event.channel)) {
      ++scan.summary.undecodable;
      newest_undecodable = std::max(newest_undecodable, event.utime);
    } else {
      ++scan.summary.other_events;
    }
  }
  for (const LogDamage& damage : reader.damage()) scan.summary.damaged_bytes += damage.bytes;
  scan.summary.events = std::ssize(scan.events);
  return scan;
}

}  // namespace

nlohmann::json ToJson(const IndexSummary& summary) {
  return {{"bytes", summary.stamp.bytes},       {"mtime_ns", summary.stamp.mtime_ns},
          {"events", summary.events},           {"other_events", summary.other_events},
          {"undecodable", summary.undecodable}, {"damaged_bytes", summary.damaged_bytes},
          {"cuttable", summary.cuttable}};
}

IndexSummary IndexSummaryFrom(const nlohmann::json& json) {
  return {.stamp = {.bytes = CountIn(json, "bytes"), .mtime_ns = IntegerIn(json, "mtime_ns")},
          .events = CountIn(json, "events"),
          .other_events = CountIn(json, "other_events"),
          .undecodable = CountIn(json, "undecodable"),
          .damaged_bytes = CountIn(json, "damaged_bytes"),
          .cuttable = FlagIn(json, "cuttable")};
}

FileStamp StampOf(const fs::path& log) {
  struct stat status {};
  if (stat(log.c_str(), &status) != 0 || !S_ISREG(status.st_mode)) {
    throw LogError(log, "no such file");
  }
  return {.bytes = status.st_size,
          .mtime_ns = int64_t{status.st_mtim.tv_sec} * 1'000'000'000 + status.st_mtim.tv_nsec};
}

void WriteIndex(const fs::path& path, const IndexSummary& summary,
                const std::vector<IndexedEvent>& events) {
  std::string lines;
  for (const IndexedEvent& event : events) lines += LineOf(event);
  OutputFile file(path, OutputFile::OverInput::kAllowed);  // a damaged one was read
  file.Write(HeadLine({.summary = summary, .bytes = std::ssize(lines), .digest = Digest(lines)}));
  file.Write(lines);
  CommitFile(path, file);
}

bool LogIndex::IsOf(const fs::path& index, const FileStamp& stamp) {
  try {
    const InputFile file(index);
    FileWindow window(file, kMaxLine);
    const std::string_view start = AsText(window.View(0, kMaxLine));
    const std::string_view line = start.substr(0, start.find('\n'));
    const IndexHead head = ParseHead(index, line);
    return head.summary.stamp == stamp && file.size() == std::ssize(line) + 1 + head.bytes;
  } catch (const LogError&) {
    return false;
  }
}

LogIndex LogIndex::Ensure(const fs::path& log, const fs::path& fallback) {
  const FileStamp stamp = StampOf(log);
  fs::path beside = log;
  beside += ".index";
  const fs::path absolute = fs::absolute(log).lexically_normal();
  const fs::path elsewhere = fallback / (Digest(absolute.string()) + ".index");
  std::string replaced;
  for (const fs::path& path : {beside, elsewhere}) {
    std::error_code ignored;
    if (!fs::is_regular_file(path, ignored)) continue;
    try {
      LogIndex index = Read(path);
      if (index.summary().stamp == stamp) return index;
    } catch (const LogError& e) {
      replaced = e.what();
    }
  }
  const Scan scan = ScanLog(log);
  if (!(StampOf(log) == stamp)) throw LogError(log, "changed while it was read");
  const auto write = [&](const fs::path& path) {
    WriteIndex(path, scan.summary, scan.events);
    LogIndex index = Read(path);
    index.replaced_ = replaced;
    return index;
  };
  try {
    return write(beside);
  } catch (const LogError&) {  // the folder cannot be written
    if (fallback.empty()) throw;
  }
  fs::create_directories(fallback);
  return write(elsewhere);
}

LogIndex LogIndex::Read(const fs::path& path) {
  const InputFile file(path);
  std::string text(static_cast<size_t>(file.size()), '\0');
  file.Read(0, {reinterpret_cast<uint8_t*>(text.data()), text.size()});
  const size_t end = std::min(text.find('\n'), text.size());
  const IndexHead head = ParseHead(path, std::string_view(text).substr(0, end));
  const size_t begin = std::min(end + 1, text.size());
  const std::string_view lines = std::string_view(text).substr(begin);
  if (Digest(lines) != head.digest) throw LogError(path, "the index is damaged or cut off");
  LogIndex index;
  index.path_ = path;
  index.summary_ = head.summary;
  index.events_ = ParseLines(path, static_cast<int64_t>(begin), lines);
  if (std::ssize(index.events_) != index.summary_.events) {
    throw LogError(path, "the index has another number of events than it says");
  }
  return index;
}

std::vector<IndexedEvent> ReadIndexLines(const fs::path& path, int64_t begin, int64_t end) {
  const InputFile file(path);
  if (begin < 0 || begin > end || end > file.size()) throw LogError(path, "the index has changed");
  std::string text(static_cast<size_t>(end - begin), '\0');
  file.Read(begin, {reinterpret_cast<uint8_t*>(text.data()), text.size()});
  return ParseLines(path, begin, text);
}

IndexedEvent ReadIndexLine(const fs::path& path, int64_t line) {
  const InputFile file(path);
  FileWindow window(file, kMaxLine);
  const std::string_view text = AsText(window.View(line, kMaxLine));
  return ParseLine(path, line, text.substr(0, text.find('\n')));
}

}  // namespace sprout::batch
