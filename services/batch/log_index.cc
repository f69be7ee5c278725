#include "services/batch/log_index.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <charconv>
#include <nlohmann/json.hpp>

#include "common/bus/channels.h"
#include "common/core/digest.h"
#include "common/logfile/event_format.h"
#include "common/logfile/file_window.h"
#include "common/logfile/log_reader.h"
#include "common/messages/codec.h"
#include "common/messages/message_type.h"
#include "services/batch/interrupt.h"
#include "services/batch/text_file.h"

namespace sprout::batch {
namespace {

namespace fs = std::filesystem;

constexpr int kFormat = 2;
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
  if (!type || *type == MessageType::kStatus || !IsWord(event.channel)) return std::nullopt;
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

std::string HeadLine(const IndexSummary& summary) {
  nlohmann::json head = ToJson(summary);
  head["sprout_index"] = kFormat;
  return head.dump() + "\n";
}

IndexSummary ParseHead(const fs::path& path, std::string_view line) {
  try {
    const auto head = nlohmann::json::parse(line);
    if (head.at("sprout_index") == kFormat) return IndexSummaryFrom(head);
  } catch (const nlohmann::json::exception&) {  // says more about JSON than about the file
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
      throw LogError(path_, "a line of the index is damaged; remove the file");
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

bool IsOf(const fs::path& index, const FileStamp& stamp) {
  std::error_code ignored;
  if (!fs::is_regular_file(index, ignored)) return false;
  const InputFile file(index);
  FileWindow window(file, kMaxLine);
  const std::string_view start = AsText(window.View(0, kMaxLine));
  try {
    return ParseHead(index, start.substr(0, start.find('\n'))).stamp == stamp;
  } catch (const LogError&) {
    return false;
  }
}

}  // namespace

nlohmann::json ToJson(const IndexSummary& summary) {
  return {{"bytes", summary.stamp.bytes},       {"mtime_ns", summary.stamp.mtime_ns},
          {"events", summary.events},           {"other_events", summary.other_events},
          {"undecodable", summary.undecodable}, {"damaged_bytes", summary.damaged_bytes},
          {"cuttable", summary.cuttable}};
}

IndexSummary IndexSummaryFrom(const nlohmann::json& json) {
  return {.stamp = {.bytes = json.at("bytes"), .mtime_ns = json.at("mtime_ns")},
          .events = json.at("events"),
          .other_events = json.at("other_events"),
          .undecodable = json.at("undecodable"),
          .damaged_bytes = json.at("damaged_bytes"),
          .cuttable = json.at("cuttable")};
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
  OutputFile file(path);
  file.Write(HeadLine(summary));
  for (const IndexedEvent& event : events) file.Write(LineOf(event));
  CommitFile(path, file);
}

LogIndex LogIndex::Ensure(const fs::path& log, const fs::path& fallback) {
  const FileStamp stamp = StampOf(log);
  fs::path beside = log;
  beside += ".index";
  const fs::path absolute = fs::absolute(log).lexically_normal();
  const fs::path elsewhere = fallback / (Digest(absolute.string()) + ".index");
  for (const fs::path& path : {beside, elsewhere}) {
    if (IsOf(path, stamp)) return Read(path);
  }
  const Scan scan = ScanLog(log);
  if (!(StampOf(log) == stamp)) throw LogError(log, "changed while it was read");
  try {
    WriteIndex(beside, scan.summary, scan.events);
    return Read(beside);
  } catch (const LogError&) {  // the folder cannot be written
    if (fallback.empty()) throw;
  }
  fs::create_directories(fallback);
  WriteIndex(elsewhere, scan.summary, scan.events);
  return Read(elsewhere);
}

LogIndex LogIndex::Read(const fs::path& path) {
  const InputFile file(path);
  std::string text(static_cast<size_t>(file.size()), '\0');
  file.Read(0, {reinterpret_cast<uint8_t*>(text.data()), text.size()});
  const size_t end = std::min(text.find('\n'), text.size());
  LogIndex index;
  index.path_ = path;
  index.summary_ = ParseHead(path, std::string_view(text).substr(0, end));
  const size_t begin = std::min(end + 1, text.size());
  index.events_ =
      ParseLines(path, static_cast<int64_t>(begin), std::string_view(text).substr(begin));
  if (std::ssize(index.events_) != index.summary_.events) {
    throw LogError(path, "the index is cut off; remove the file");
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
