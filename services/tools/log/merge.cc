// The subcommand that writes one log of several.
#include <fmt/core.h>

#include <algorithm>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <system_error>
#include <utility>

#include "common/config/config_error.h"
#include "common/config/frame_range.h"
#include "common/core/digest.h"
#include "common/core/output_file.h"
#include "common/logfile/log_error.h"
#include "common/logfile/log_reader.h"
#include "common/logfile/log_writer.h"
#include "services/tools/log/channel_summary.h"
#include "services/tools/log/commands.h"
#include "services/tools/log/print_line.h"
#include "services/tools/log/read_progress.h"

namespace sprout::log {
namespace {

struct MergeOptions {
  std::vector<std::filesystem::path> in;
  std::filesystem::path out;
  bool replace = false;
  bool force = false;
};

using ChannelSet = std::set<std::string, std::less<>>;

bool HasAnswers(std::string_view channel) {
  const std::optional<MessageType> type = TypeOfChannel(channel);
  return type && CarriesFrames(*type);
}

// A log that is merged with others.
class MergedLog {
 public:
  explicit MergedLog(const std::filesystem::path& path) : path_(path), reader_(path) {}

  ChannelSet AnswerChannels(ReadProgress& progress) const {
    ChannelSet channels;
    LogReader ahead(path_);
    for (LogEvent event; ahead.Next(event); progress.Update(ahead.position())) {
      if (HasAnswers(event.channel)) channels.emplace(event.channel);
    }
    return channels;
  }

  void Hide(const ChannelSet& channels) { hidden_.insert(channels.begin(), channels.end()); }

  void Advance() {
    while ((is_there_ = reader_.Next(event_)) && hidden_.contains(event_.channel)) ++left_out_;
    if (is_there_ && HasAnswers(event_.channel)) ++kept_;
  }

  /// Once the log is read: whether later logs replaced all its messages of frames, as when answers
  /// are named before the recording.
  bool IsReplaced() const { return left_out_ > 0 && kept_ == 0; }

  bool is_there() const { return is_there_; }
  const LogEvent& event() const { return event_; }
  const std::filesystem::path& path() const { return path_; }
  const LogReader& reader() const { return reader_; }

 private:
  std::filesystem::path path_;
  LogReader reader_;
  ChannelSet hidden_;  // channels that a later log has
  LogEvent event_;
  bool is_there_ = false;
  int64_t left_out_ = 0;
  int64_t kept_ = 0;  // messages of frames
};

// The frames of one log on one channel: their numbers, and the times of their events, µs.
struct FrameSpan {
  FrameRange numbers;
  int64_t first_time = 0;
  int64_t last_time = 0;
};

// Finds frames that have a message on one channel in two logs, and logs whose frames would be
// shuffled. Some 100 bytes a message.
class AnswerCheck {
 public:
  /// Whether another log has had this very message, as where two recorders listened to one graph.
  /// @throws LogError when another log has had a different message for its frame.
  bool IsRepeated(const MergedLog& log) {
    const LogEvent& event = log.event();
    if (!HasAnswers(event.channel)) return false;
    const Result<FrameId> id = DecodeFrameId(event.data);
    if (!id) return false;
    Note(log, *id);
    auto& answers = answers_.try_emplace(std::string(event.channel)).first->second;
    const uint64_t hash =
        Hash({reinterpret_cast<const char*>(event.data.data()), event.data.size()});
    const auto [known, is_new] = answers.try_emplace({id->utime, id->seq}, hash, &log);
    if (is_new || known->second.second == &log) return false;
    if (known->second.first == hash) return true;
    throw LogError(log.path(),
                   fmt::format("{} of frame {} is another than in {}; --replace takes the channel "
                               "from the last log that has it",
                               event.channel, id->seq, known->second.second->path().string()));
  }

  /// @throws LogError when frames of one log come before those of another one by their numbers, and
  ///         among them by time, as of two parts of a recording between which the clock was set
  ///         back.
  void RequireOneOrder() const {
    for (const auto& [channel, spans] : spans_) {
      for (const auto& [log, span] : spans) {
        for (const auto& [other, later] : spans) {
          if (span.numbers.last >= later.numbers.first || span.last_time <= later.first_time ||
              span.first_time >= later.last_time) {
            continue;
          }
          throw LogError(
              other->path(),
              fmt::format("{} has frames from {} on, and by time they lie among frames {} to {} of "
                          "{}: the clock was set back; `cat` joins logs by their order",
                          channel, later.numbers.first, span.numbers.first, span.numbers.last,
                          log->path().string()));
        }
      }
    }
  }

 private:
  void Note(const MergedLog& log, const FrameId& id) {
    const int64_t time = log.event().utime;
    const auto [found, is_new] =
        spans_[std::string(log.event().channel)].try_emplace(&log, FrameSpan{});
    FrameSpan& span = found->second;
    if (is_new) span = {{.first = id.seq, .last = id.seq}, time, time};
    span.numbers.first = std::min(span.numbers.first, id.seq);
    span.numbers.last = std::max(span.numbers.last, id.seq);
    span.first_time = std::min(span.first_time, time);
    span.last_time = std::max(span.last_time, time);
  }

  using Answer = std::pair<uint64_t, const MergedLog*>;  // digest, and where it is from
  std::map<std::string, std::map<std::pair<int64_t, int64_t>, Answer>, std::less<>> answers_;
  std::map<std::string, std::map<const MergedLog*, FrameSpan>, std::less<>> spans_;
};

// Each log keeps its order; of equal times the log named first comes first.
MergedLog& NextOf(const std::vector<std::unique_ptr<MergedLog>>& logs) {
  return **std::ranges::min_element(logs, [](const auto& a, const auto& b) {
    if (a->is_there() != b->is_there()) return a->is_there();
    return a->is_there() && a->event().utime < b->event().utime;
  });
}

// A log beside itself would have every message twice.
void RequireDifferentLogs(const std::vector<std::filesystem::path>& paths) {
  for (size_t later = 1; later < paths.size(); ++later) {
    for (size_t i = 0; i < later; ++i) {
      std::error_code none;
      if (paths[i] != paths[later] && !std::filesystem::equivalent(paths[i], paths[later], none)) {
        continue;
      }
      throw ConfigError(paths[i].string() + " and " + paths[later].string() +
                        " are one log; allowed: each once");
    }
  }
}

int RunMerge(const MergeOptions& options) {
  RequireDifferentLogs(options.in);
  std::vector<std::unique_ptr<MergedLog>> logs;
  int64_t bytes = 0;
  for (const auto& path : options.in) {
    logs.push_back(std::make_unique<MergedLog>(path));
    bytes += logs.back()->reader().size();
  }
  for (size_t later = 1; options.replace && later < logs.size(); ++later) {
    ReadProgress progress("reading " + options.in[later].string(), logs[later]->reader().size());
    const ChannelSet channels = logs[later]->AnswerChannels(progress);
    for (size_t i = 0; i < later; ++i) logs[i]->Hide(channels);
  }
  for (const auto& log : logs) log->Advance();
  LogWriter out(options.out, options.force, OutputFile::OverInput::kAllowed);
  ReadProgress progress("merging", bytes);
  AnswerCheck check;
  int64_t repeated = 0;
  for (MergedLog* next = &NextOf(logs); next->is_there(); next = &NextOf(logs)) {
    if (!options.replace && check.IsRepeated(*next)) {
      ++repeated;
    } else {
      out.Write(next->event().utime, next->event().channel, next->event().data);
    }
    next->Advance();
    int64_t position = 0;
    for (const auto& log : logs) position += log->reader().position();
    progress.Update(position);
  }
  progress.Clear();
  for (const auto& log : logs) WarnOfDamage(log->path(), log->reader().damage());
  for (const auto& log : logs) {
    if (!log->IsReplaced()) continue;
    PrintWarning(log->path().string() +
                 ": no frame of it is used: later logs have its channels; the log that replaces a "
                 "part of a recording is named behind it");
  }
  check.RequireOneOrder();
  out.Close();
  PrintLine(fmt::format("{}: {} of {} events", options.out.string(), out.events(),
                        out.events() + repeated) +
            (repeated > 0 ? "; messages of frames that two logs have are there once" : ""));
  return 0;
}

}  // namespace

void AddMerge(Flags& program) {
  const auto options = std::make_shared<MergeOptions>();
  Flags& flags = program.AddCommand(
      "merge",
      "Merges logs into one, by the time of their events. Logs that have different messages for "
      "one\nframe, such as a recording and the replay of one of its stages, need --replace",
      [options] { return RunMerge(*options); });
  flags.Add("IN", options->in, "Logs; of equal times, the log named first comes first").Required();
  flags.Add("--out OUT", options->out, "New log").Required();
  flags.Add("--replace", options->replace,
            "Take a channel from the last log that has it, as --replay does: later answers replace "
            "earlier ones. Of statuses and SPROUT_PROCESS all are kept");
  AddForce(flags, options->force);
}

}  // namespace sprout::log
