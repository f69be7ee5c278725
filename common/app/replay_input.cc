#include "common/app/replay_input.h"

#include <algorithm>
#include <utility>

#include "common/app/log.h"

namespace sprout {
namespace {

std::set<std::string, std::less<>> ChannelsOf(const std::string& path) {
  std::set<std::string, std::less<>> channels;
  LogReader reader(path);
  LogEvent event;
  while (reader.Next(event)) {
    if (!channels.contains(event.channel)) channels.emplace(event.channel);
  }
  return channels;
}

}  // namespace

ReplayInput::ReplayInput(const std::vector<std::string>& logs, std::string_view shared,
                         std::set<std::string, std::less<>> ordering)
    : ordering_(std::move(ordering)) {
  for (const std::string& path : logs) {
    logs_.push_back({.path = path,
                     .reader = std::make_unique<LogReader>(path),
                     .hidden = {},
                     .head = {},
                     .damage_seen = 0});
  }
  for (size_t later = 1; later < logs_.size(); ++later) {
    auto channels = ChannelsOf(logs_[later].path);
    channels.erase(std::string(shared));
    for (size_t i = 0; i < later; ++i) logs_[i].hidden.insert(channels.begin(), channels.end());
  }
  for (Log& log : logs_) Advance(log);
}

bool ReplayInput::Next(LogEvent& event) {
  if (taken_ != nullptr) Advance(*taken_);
  taken_ = nullptr;
  for (Log& log : logs_) {
    if (log.head && (taken_ == nullptr || log.time < taken_->time)) taken_ = &log;
  }
  if (taken_ == nullptr) return false;
  event = *taken_->head;
  ++events_;
  channels_.Add(event.channel);
  return true;
}

void ReplayInput::Advance(Log& log) {
  LogEvent event;
  log.head.reset();
  while (!log.head && log.reader->Next(event)) {
    if (!log.hidden.contains(event.channel)) log.head = event;
  }
  if (log.head && (ordering_.empty() || ordering_.contains(log.head->channel))) {
    log.time = std::max(log.time, log.head->utime);
  }
  ReportDamage(log);
}

void ReplayInput::ReportDamage(Log& log) {
  const std::vector<LogDamage>& damage = log.reader->damage();
  for (; log.damage_seen < damage.size(); ++log.damage_seen) {
    damaged_bytes_ += damage[log.damage_seen].bytes;
    LogLine(LogLevel::kWarning, "{}: {}", log.path, SkippedText(damage[log.damage_seen]));
  }
}

double ReplayInput::progress() const {
  int64_t position = 0;
  int64_t size = 0;
  for (const Log& log : logs_) {
    position += log.reader->position();
    size += log.reader->size();
  }
  return size == 0 ? 1 : static_cast<double>(position) / static_cast<double>(size);
}

}  // namespace sprout
