#include "common/logfile/event_list.h"

#include <algorithm>
#include <sstream>

namespace sprout {

std::string EventList::Text(const std::filesystem::path& log, const std::vector<Entry>& entries) {
  std::string text = std::string(kMagic) + log.string() + "\n";
  for (const Entry& entry : entries) {
    text += std::to_string(entry.offset) + " " + std::to_string(entry.utime) + "\n";
  }
  return text;
}

std::unique_ptr<EventList> EventList::Open(const InputFile& file) {
  if (file.path().parent_path() != "/dev/fd") return nullptr;
  std::string text(std::min(static_cast<size_t>(file.size()), kMagic.size()), '\0');
  file.Read(0, {reinterpret_cast<uint8_t*>(text.data()), text.size()});
  if (text != kMagic) return nullptr;
  text.resize(static_cast<size_t>(file.size()));
  file.Read(0, {reinterpret_cast<uint8_t*>(text.data()), text.size()});
  std::istringstream lines(text.substr(kMagic.size()));
  std::string log;
  std::getline(lines, log);
  std::vector<Entry> entries;
  for (Entry entry; lines >> entry.offset >> entry.utime;) entries.push_back(entry);
  if (!lines.eof()) throw LogError(file.path(), "a list of events with a damaged line");
  return std::unique_ptr<EventList>(new EventList(log, std::move(entries)));
}

bool EventList::Next(LogEvent& event) {
  if (next_ == entries_.size()) return false;
  const Entry& entry = entries_[next_];
  event = fetcher_.Fetch(entry.offset);
  event.number = static_cast<int64_t>(next_++);
  event.utime = entry.utime;
  return true;
}

}  // namespace sprout
