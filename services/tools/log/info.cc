#include <fmt/chrono.h>
#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <ctime>
#include <iostream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <utility>

#include "common/app/status_board.h"
#include "common/config/config.h"
#include "common/core/frame.h"
#include "common/core/joined.h"
#include "common/core/printable.h"
#include "common/messages/codec.h"
#include "common/messages/message_type.h"
#include "services/tools/log/channel_summary.h"
#include "services/tools/log/commands.h"
#include "services/tools/log/read_progress.h"

namespace sprout::log {
namespace {

using Json = nlohmann::ordered_json;

constexpr size_t kShownDamage = 20;

struct LogSummary {
  int64_t bytes = 0;
  int64_t events = 0;
  int64_t first_utime = 0;
  int64_t last_utime = 0;
  std::map<std::string, ChannelSummary, std::less<>> channels;
  ProcessSummary processes;
  StatusBoard statuses{{}};
  std::vector<LogDamage> damage;
  std::string other_channel;  // a channel without the prefix
  int64_t set_back = 0;       // how often the clock was set back
  double set_back_s = 0;      // by how much at most
  double pause_s = 0;         // the longest time without any event
};

// A message may be recorded behind one that is later by less, though no clock was set back.
constexpr double kMinSetBackS = 1;

// A graph that runs sends statuses once a second, so such a silence is remarked on.
constexpr double kMinPauseS = 60;

// A time of the log for the board, whose clock is that of the log here.
StatusBoard::Clock::time_point TimeOf(int64_t utime) {
  return StatusBoard::Clock::time_point(std::chrono::microseconds(utime));
}

void AddStatus(const LogEvent& event, StatusBoard& statuses) {
  const Result<StageStatus> status = DecodeStatus(event.data);
  if (status) statuses.Add(*status, TimeOf(event.utime));
}

// N where sprout-depth sent depth of every Nth frame, by its newest configuration in the log.
int64_t DepthEvery(const ProcessSummary& processes) {
  const ProcessInfo* depth = processes.NewestOf("depth");
  if (depth == nullptr) return 1;
  try {
    return LoadConfig({depth->config_text}).depth().every();
  } catch (const ConfigError&) {  // the log is of another version
    return 1;
  }
}

LogSummary Summarize(const InfoOptions& options) {
  LogReader reader(options.file);
  LogSummary log;
  log.bytes = reader.size();
  ReadProgress progress("reading " + options.file.string(), reader.size());
  std::optional<int64_t> newest_utime;
  for (LogEvent event; reader.Next(event); progress.Update(reader.position())) {
    const int64_t before = std::exchange(newest_utime, event.utime).value_or(event.utime);
    const double set_back_s =
        (static_cast<double>(before) - static_cast<double>(event.utime)) / 1e6;
    log.pause_s = std::max(log.pause_s, -set_back_s);
    if (set_back_s > kMinSetBackS) {
      ++log.set_back;
      log.set_back_s = std::max(log.set_back_s, set_back_s);
    }
    if (!event.channel.starts_with(options.prefix)) {
      if (log.other_channel.empty()) log.other_channel = event.channel;
      continue;
    }
    auto channel = log.channels.find(event.channel);
    if (channel == log.channels.end()) {
      channel = log.channels.emplace(event.channel, ChannelSummary()).first;
    }
    channel->second.Add(event);
    const std::optional<MessageType> type = TypeOf(event.data);
    if (type == MessageType::kProcess) log.processes.Add(event.data);
    if (type == MessageType::kStatus) AddStatus(event, log.statuses);
  }
  log.damage = reader.damage();
  for (auto& [name, channel] : log.channels) {
    const std::optional<Part> part = PartOf(name, options.prefix);
    if (part && IsOfDepth(*part)) channel.ExpectEvery(DepthEvery(log.processes));
  }
  for (const auto& [name, channel] : log.channels) {
    const bool first = log.events == 0;
    log.first_utime =
        first ? channel.first_utime() : std::min(log.first_utime, channel.first_utime());
    log.last_utime = first ? channel.last_utime() : std::max(log.last_utime, channel.last_utime());
    log.events += channel.events();
  }
  return log;
}

// Whether no channel of the log has the prefix, so that nothing was looked at.
bool IsOfAnotherGraph(const LogSummary& log) {
  return log.channels.empty() && !log.other_channel.empty();
}

bool IsWhole(const LogSummary& log) {
  if (log.bytes == 0 || !log.damage.empty() || IsOfAnotherGraph(log)) return false;
  return std::all_of(log.channels.begin(), log.channels.end(), [](const auto& entry) {
    return entry.second.undecodable() == 0 && entry.second.sequence().missing() == 0;
  });
}

double Seconds(const LogSummary& log, int64_t utime) {
  return (static_cast<double>(utime) - static_cast<double>(log.first_utime)) / 1e6;
}

std::string TimeText(int64_t utime) {
  // Damaged times may lie where no calendar reaches.
  constexpr int64_t kYear3000 = 32'503'680'000'000'000;
  if (utime < 0 || utime >= kYear3000) return fmt::format("utime {}", utime);
  const auto second = static_cast<std::time_t>(utime / 1'000'000);
  return fmt::format("{:%Y-%m-%d %H:%M:%S}.{:06} UTC (utime {})", fmt::gmtime(second),
                     utime % 1'000'000, utime);
}

std::string FramesText(const ChannelSummary& channel) {
  if (!channel.has_frames()) return "";
  return fmt::format("{}-{}", *channel.sequence().first(), *channel.sequence().last());
}

std::string Table(const LogSummary& log) {
  size_t name_width = 7;
  for (const auto& [name, channel] : log.channels) name_width = std::max(name_width, name.size());
  std::string text =
      fmt::format("{:<{}}  {:<24} {:>8} {:>7} {:>9} {:>8} {:>8} {:>12} {:>7} {:>8} {:>11}\n",
                  "channel", name_width, "type", "messages", "per s", "MB", "first s", "last s",
                  "frames", "missing", "repeated", "undecodable");
  for (const auto& [name, channel] : log.channels) {
    const Sequence& sequence = channel.sequence();
    text += fmt::format(
        "{:<{}}  {:<24} {:>8} {:>7} {:>9.2f} {:>8.3f} {:>8.3f} {:>12} {:>7} {:>8} {:>11}\n", name,
        name_width, channel.type(), channel.events(),
        std::isnan(channel.rate_hz()) ? "" : fmt::format("{:.2f}", channel.rate_hz()),
        static_cast<double>(channel.bytes()) / 1e6, Seconds(log, channel.first_utime()),
        Seconds(log, channel.last_utime()), FramesText(channel),
        channel.has_frames() ? fmt::format("{}", sequence.missing()) : "",
        channel.has_frames() ? fmt::format("{}", sequence.repeated()) : "", channel.undecodable());
  }
  return text;
}

// Raw images have an empty rig_id, which does not count.
std::string RigsText(const LogSummary& log) {
  std::set<std::string> rigs;
  for (const auto& [name, channel] : log.channels) {
    for (const std::string& rig : channel.sequence().rigs()) rigs.insert(Printable(rig));
  }
  rigs.erase("");
  if (rigs.size() < 2) return "";
  return fmt::format("frames of several calibrations, rig_id: {}\n", Joined(", ", rigs));
}

std::string Remarks(const LogSummary& log) {
  std::string text;
  if (IsOfAnotherGraph(log)) {
    text += fmt::format("no channel begins with this --channel-prefix; there are channels as {}\n",
                        log.other_channel);
  }
  for (const auto& [name, channel] : log.channels) {
    const Sequence& sequence = channel.sequence();
    if (sequence.missing() > 0) {
      text += fmt::format("{}: frames left out: {}\n", name, sequence.GapText());
    }
    if (sequence.late() > 0) {
      text += fmt::format("{}: frames that stand behind later ones: {}\n", name, sequence.late());
    }
    if (sequence.times_back() > 0) {
      text +=
          fmt::format("{}: frames whose utime does not rise: {}\n", name, sequence.times_back());
    }
    if (sequence.restarts() > 0) {
      text += fmt::format("{}: frame numbers began anew, times: {}\n", name, sequence.restarts());
    }
    if (channel.undecodable() > 0) {
      text += fmt::format("{}: first undecodable message: {}\n", name,
                          Printable(channel.first_error()));
    }
  }
  text += RigsText(log);
  if (log.set_back > 0) {
    text += fmt::format(
        "the clock was set back, times: {}, by {:.3f} s at most: times and rates above are wrong\n",
        log.set_back, log.set_back_s);
  }
  if (log.pause_s > kMinPauseS) {
    text += fmt::format(
        "no message for {:.3f} s: a pause, or the clock was set forward; rates above are over all "
        "that time\n",
        log.pause_s);
  }
  for (size_t i = 0; i < std::min(log.damage.size(), kShownDamage); ++i) {
    text += "damage: " + DamageText(log.damage[i]) + "\n";
  }
  if (log.damage.size() > kShownDamage) {
    text += fmt::format("damage: and {} more\n", log.damage.size() - kShownDamage);
  }
  return text;
}

// A process that ran on no host is one of a replay.
std::string ProcessTable(const LogSummary& log) {
  if (log.processes.processes().empty()) return "";
  std::string text =
      fmt::format("\n{:<12} {:<22} {:<18} host\n", "process", "version", "configuration");
  for (const ProcessInfo& process : log.processes.processes()) {
    text += fmt::format("{:<12} {:<22} {:<18} {}\n", Printable(process.stage),
                        Printable(process.version), Printable(process.config_digest),
                        process.host.empty() ? "(replay)" : Printable(process.host));
  }
  return text;
}

// The newest status of every process, as sprout-top shows them.
std::string StatusTable(const LogSummary& log) {
  const std::vector<BoardRow> rows = log.statuses.Rows(TimeOf(log.last_utime));
  return rows.empty() ? "" : "\n" + BoardText(rows, false);
}

std::string ConfigTexts(const LogSummary& log) {
  std::string text;
  std::set<std::string> printed;
  for (const ProcessInfo& process : log.processes.processes()) {
    if (!printed.insert(process.config_digest).second) continue;
    text += fmt::format("\nconfiguration {} of {}:\n{}", Printable(process.config_digest),
                        Printable(process.stage), PrintableLines(process.config_text));
  }
  return text.empty() ? "\nno configuration is in the log (SPROUT_PROCESS)\n" : text;
}

std::string Text(const LogSummary& log, const InfoOptions& options) {
  std::string text = fmt::format("{}: {:.2f} MB, {} events", Printable(options.file.string()),
                                 static_cast<double>(log.bytes) / 1e6, log.events);
  if (log.events > 0) {
    text += fmt::format(" in {:.3f} s\nfirst {}\nlast  {}\n\n{}", Seconds(log, log.last_utime),
                        TimeText(log.first_utime), TimeText(log.last_utime), Table(log)) +
            ProcessTable(log) + StatusTable(log);
  } else {
    text += "\n";
  }
  const std::string remarks = Remarks(log);
  text += remarks.empty() ? "" : "\n" + remarks;
  if (log.bytes == 0) return text + "the file is empty: nothing was written to it\n";
  return text + (log.damage.empty() ? "no damage\n" : "") +
         (options.config ? ConfigTexts(log) : "");
}

Json ChannelJson(const std::string& name, const ChannelSummary& channel) {
  Json json = {{"name", name},
               {"type", channel.type()},
               {"messages", channel.events()},
               {"bytes", channel.bytes()},
               {"rate_hz", channel.rate_hz()},
               {"first_utime", channel.first_utime()},
               {"last_utime", channel.last_utime()},
               {"undecodable", channel.undecodable()}};
  if (channel.has_frames()) {
    const Sequence& sequence = channel.sequence();
    json["frames"] = {{"first", *sequence.first()},
                      {"last", *sequence.last()},
                      {"missing", sequence.missing()},
                      {"repeated", sequence.repeated()},
                      {"restarts", sequence.restarts()}};
  }
  return json;
}

std::string JsonText(const LogSummary& log, const std::filesystem::path& file) {
  Json channels = Json::array();
  for (const auto& [name, channel] : log.channels) channels.push_back(ChannelJson(name, channel));
  Json processes = Json::array();
  for (const ProcessInfo& process : log.processes.processes()) {
    processes.push_back({{"stage", process.stage},
                         {"host", process.host},
                         {"pid", process.pid},
                         {"version", process.version},
                         {"config_digest", process.config_digest},
                         {"config_text", process.config_text}});
  }
  Json damage = Json::array();
  for (const LogDamage& stretch : log.damage) {
    Json entry = {{"offset", stretch.offset}, {"bytes", stretch.bytes}, {"tail", stretch.tail}};
    entry["events"] = stretch.events ? Json(*stretch.events) : Json(nullptr);
    damage.push_back(std::move(entry));
  }
  const Json json = {{"file", file.string()},        {"bytes", log.bytes},
                     {"events", log.events},         {"first_utime", log.first_utime},
                     {"last_utime", log.last_utime}, {"whole", IsWhole(log)},
                     {"set_back", log.set_back},     {"channels", channels},
                     {"processes", processes},       {"damage", damage}};
  // Paths and channels may hold any bytes; JSON may not.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

int RunInfo(const InfoOptions& options) {
  if (IsMcap(options.file)) return RunMcapInfo(options);
  const LogSummary log = Summarize(options);
  std::cout << (options.json ? JsonText(log, options.file) : Text(log, options));
  return options.check && !IsWhole(log) ? 1 : 0;
}

}  // namespace

void AddInfo(Flags& program) {
  const auto options = std::make_shared<InfoOptions>();
  Flags& flags = program.AddCommand(
      "info",
      "Prints for each channel type, messages, rate, times, frames, and how many frame numbers "
      "are\nmissing, repeated or undecodable; and where the file is damaged",
      [options] { return RunInfo(*options); });
  flags.Add("FILE", options->file, "Log, or MCAP file").Required();
  AddPrefix(flags, options->prefix);
  flags.Add("--json", options->json, "For programs; has the configurations, too");
  flags.Add("--config", options->config, "Also the effective configuration of each process");
  flags.Add("--check", options->check,
            "Exit code 1 when something is damaged or undecodable, or frame numbers are missing");
}

}  // namespace sprout::log
