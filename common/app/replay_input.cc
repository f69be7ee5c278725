#include "common/app/replay_input.h"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

#include "common/app/log.h"
#include "common/messages/codec.h"
#include "common/messages/message_type.h"

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
                     .left_out = {},
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
  taken_->is_used = taken_->is_used || ordering_.contains(event.channel);
  Note(event, read_);
  ++events_;
  channels_.Add(event.channel);
  return true;
}

void ReplayInput::Advance(Log& log) {
  LogEvent event;
  log.head.reset();
  while (!log.head && log.reader->Next(event)) {
    if (log.hidden.contains(event.channel)) {
      Note(event, log.left_out);
    } else {
      log.head = event;
    }
  }
  if (log.head && (ordering_.empty() || ordering_.contains(log.head->channel))) {
    log.time = std::max(log.time, log.head->utime);
  }
  ReportDamage(log);
}

// A calibration belongs to no frame, and may be replaced by one of another time.
void ReplayInput::Note(const LogEvent& event, Spans& spans) const {
  if (!ordering_.contains(event.channel) || TypeOf(event.data) == MessageType::kRig) return;
  const Result<FrameId> id = DecodeFrameId(event.data);
  if (!id) return;
  Span& span = spans[std::string(event.channel)];
  if (span.messages++ == 0) {
    span.first_utime = span.last_utime = id->utime;
    span.numbers = {.first = id->seq, .last = id->seq};
  }
  span.first_utime = std::min(span.first_utime, id->utime);
  span.last_utime = std::max(span.last_utime, id->utime);
  span.numbers.first = std::min(span.numbers.first, id->seq);
  span.numbers.last = std::max(span.numbers.last, id->seq);
  if (span.rigs.size() < kMaxRigs) span.rigs.insert(id->rig_id);
}

bool ReplayInput::AreOthers(const Span& left_out, const Span& read) {
  if (left_out.last_utime < read.first_utime || left_out.first_utime > read.last_utime) return true;
  if (left_out.numbers.last < read.numbers.first || left_out.numbers.first > read.numbers.last) {
    return true;
  }
  return read.rigs.size() < kMaxRigs && std::ranges::none_of(left_out.rigs, [&](const auto& rig) {
           return read.rigs.contains(rig);
         });
}

std::vector<std::string> ReplayInput::LeftOut() const {
  std::vector<std::string> lines;
  for (const Log& log : logs_) {
    for (const auto& [channel, left_out] : log.left_out) {
      const auto read = read_.find(channel);
      if (read == read_.end()) continue;
      const Span& span = read->second;
      const bool are_others = AreOthers(left_out, span);
      if (log.is_used && !are_others) continue;
      const bool is_replaced = !are_others && left_out.first_utime >= span.first_utime &&
                               left_out.last_utime <= span.last_utime;
      lines.push_back(
          is_replaced
              ? fmt::format("{}: nothing of it is used: a later --replay has {}; the log that "
                            "replaces a part of a recording is named behind it",
                            log.path, channel)
              : fmt::format(
                    "{}: {} messages on {} are not used: a later --replay has that channel, "
                    "of other frames; `sprout-log merge` joins the parts of a recording",
                    log.path, left_out.messages, channel));
      break;
    }
  }
  return lines;
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
