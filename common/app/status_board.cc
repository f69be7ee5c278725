#include "common/app/status_board.h"

#include <fmt/core.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "common/core/printable.h"

namespace sprout {
namespace {

// Frames and messages that a process did not use.
int64_t Losses(const StageStatus& status) {
  return status.frames_skipped + status.frames_incomplete + status.frames_failed +
         status.frames_degenerate + status.bad_messages + status.sequence_gaps;
}

struct Look {
  std::string_view name;
  std::string_view colour;
};

// In the order of Health.
constexpr Look kLooks[] = {{"good", "\x1b[32m"},  {"losing", "\x1b[33m"}, {"twice", "\x1b[31m"},
                           {"stale", "\x1b[31m"}, {"stopped", "\x1b[2m"}, {"missing", "\x1b[31m"}};
static_assert(std::size(kLooks) == static_cast<size_t>(Health::kMissing) + 1, "each has a look");

const Look& LookOf(Health health) { return kLooks[static_cast<size_t>(health)]; }

std::string HealthText(Health health, bool colour) {
  const std::string text = fmt::format("{:<8}", NameOf(health));
  return colour ? fmt::format("{}{}\x1b[0m", LookOf(health).colour, text) : text;
}

bool IsHeard(const BoardRow& row) { return row.health != Health::kMissing; }

// Which clocks tell the age of what a process answers: "one", as the capture runs on the same host,
// or it is not known where; "two", right as far as those of the two hosts agree; "wrong", as frames
// come from the future.
std::string_view ClocksOf(const BoardRow& row, const std::vector<BoardRow>& rows) {
  if (row.status.age.p50_ms < 0) return "wrong";
  for (const BoardRow& other : rows) {
    if (other.status.stage != "capture" || !IsHeard(other)) continue;
    if (other.status.host != row.status.host) return "two";
  }
  return "one";
}

// Frames that are so old are no live ones: they come from a recording.
constexpr double kOldMs = 100'000;

bool IsOld(const StageStatus& status) { return status.age.p50_ms > kOldMs; }

std::string AgeText(double age_ms, std::string_view clocks) {
  if (clocks == "wrong") return "?";
  if (age_ms > kOldMs) return "old";
  return fmt::format("{}{:.0f}", clocks == "two" ? "~" : "", age_ms);
}

std::string RateText(double rate_hz) {
  return rate_hz > 0 && rate_hz < 0.95 ? fmt::format("{:.2g}", rate_hz)
                                       : fmt::format("{:.1f}", rate_hz);
}

std::string RowText(const BoardRow& row, const std::vector<BoardRow>& rows, bool colour) {
  const StageStatus& s = row.status;
  const std::string start = fmt::format("{:<10.10} {}", s.stage, HealthText(row.health, colour));
  if (!IsHeard(row)) return start + "\n";
  const std::string_view clocks = ClocksOf(row, rows);
  const std::string cover =
      s.tof_coverage < 0 ? "-" : fmt::format("{:.0f} %", 100 * s.tof_coverage);
  return start + fmt::format(
                     "{:>6} {:>6} {:>8} {:>6.0f} {:>6.0f} {:>6} {:>6} {:>6} {:>6} {:>5} {:>5} "
                     "{:>5} {:>6.0f} {:>5}  {}:{}\n",
                     s.newest_frame.seq, RateText(s.rate_hz), s.frames_out, s.latency.p50_ms,
                     s.latency.p99_ms, AgeText(s.age.p50_ms, clocks), AgeText(s.age.p99_ms, clocks),
                     s.frames_skipped, s.frames_incomplete, s.sequence_gaps,
                     s.frames_failed + s.frames_degenerate, s.bad_messages,
                     static_cast<double>(s.rss_bytes) / (1 << 20), cover, s.host, s.pid);
}

// What to check where stages run on two hosts and some are not heard.
std::string HostsText(const std::vector<BoardRow>& rows) {
  std::string missing;
  bool heard = false;
  bool two_clocks = false;
  for (const BoardRow& row : rows) {
    heard = heard || IsHeard(row);
    if (!IsHeard(row)) missing += (missing.empty() ? "" : ", ") + row.status.stage;
    two_clocks = two_clocks || (IsHeard(row) && ClocksOf(row, rows) == "two");
  }
  const bool any_old = std::ranges::any_of(
      rows, [](const BoardRow& row) { return IsHeard(row) && IsOld(row.status); });
  std::string text;
  if (!heard)
    text += "nothing is heard: is the graph running with this --lcm-url and --channel-prefix?\n";
  if (any_old) {
    text +=
        "old: captured more than 100 s ago, as frames of a recording are, and those whose utime is "
        "not in µs since 1970\n";
  }
  if (heard && !missing.empty()) {
    text += missing +
            ": not heard here; if on another host: ttl=1 in every --lcm-url, no route of the group "
            "over lo\n";
  }
  if (two_clocks) text += "~: compares the clocks of two hosts, right if they agree (NTP, PTP)\n";
  return text;
}

// The stages that make one map, by the digests of their configurations; empty when these are equal.
// Others have parameters of their own: that of capture has its source.
std::string ConfigurationsText(const std::vector<BoardRow>& rows) {
  std::map<std::string, std::string> stages;  // by digest
  for (const BoardRow& row : rows) {
    const StageStatus& s = row.status;
    const bool makes_map = s.stage == "refine" || s.stage == "prior" || s.stage == "grow";
    if (!makes_map || s.config_digest.empty()) continue;
    std::string& names = stages[s.config_digest];
    names += (names.empty() ? "" : ", ") + s.stage;
  }
  if (stages.size() < 2) return "";
  std::string text;
  for (const auto& [digest, names] : stages) {
    text += fmt::format("{}{}: {}", text.empty() ? "" : "; ", names, digest);
  }
  return "configurations differ: " + text;
}

// What capture and refine know about the cameras.
std::string CameraText(const StageStatus& s) {
  std::string text;
  if (s.spread_ms >= 0) {
    text = fmt::format("{}: exposures of a frame within {:.2f} ms\n", s.stage, s.spread_ms);
  }
  if (s.tof_offset.IsSignificant()) {
    text += fmt::format(
        "{}: ToF points off by ({:.1f}, {:.1f}) ± {:.1f} px, and edges of depth with them: "
        "calibrate again; refine {{ align_tof: true }} corrects it until then\n",
        s.stage, -s.tof_offset.u_px, -s.tof_offset.v_px, s.tof_offset.sigma_px);
  }
  return text;
}

std::string TimeText(double seconds) {
  constexpr double kMinute = 60;
  constexpr double kHour = 60 * kMinute;
  if (seconds < kMinute) return fmt::format("{:.0f} s", seconds);
  if (seconds < kHour) return fmt::format("{:.0f} min", seconds / kMinute);
  return fmt::format("{:.1f} h", seconds / kHour);
}

// The newest error of a process and when it came; a process takes back what is over.
std::string ErrorText(const BoardRow& row) {
  if (!row.error_age_s) return "";
  return fmt::format("{}, {}{} ago: {}\n", row.status.stage, row.error_was_there ? "over " : "",
                     TimeText(*row.error_age_s), row.status.last_error);
}

}  // namespace

bool StatusBoard::Add(const StageStatus& message, Clock::time_point now) {
  // Whoever sends a status must not move the terminal's cursor.
  StageStatus status = message;
  for (std::string* text :
       {&status.stage, &status.host, &status.config_digest, &status.last_error}) {
    *text = Printable(*text);
  }
  const Process process{status.stage, status.host, status.pid};
  const auto found = heard_.find(process);
  if (found != heard_.end()) {
    Heard& heard = found->second;
    if (Losses(status) > Losses(heard.newest)) heard.loss = now;
    if (status.last_error != heard.newest.last_error) {
      heard.error_since = now;
      heard.error_was_there = false;
    }
    heard.newest = status;
    heard.when = now;
    return true;
  }
  if (heard_.size() == kMaxProcesses) {
    // One that has ended makes room: stages may start again and again.
    const auto ended = std::ranges::find_if(heard_, [&](const auto& entry) {
      return entry.second.newest.state == StageStatus::State::kStopped ||
             now - entry.second.when > kStaleAfter;
    });
    if (ended == heard_.end()) {
      ++left_out_.no_room;
      return false;
    }
    heard_.erase(ended);
  }
  heard_.emplace(
      process,
      Heard{
          .newest = status, .when = now, .error_since = now, .error_was_there = true, .loss = {}});
  return true;
}

size_t StatusBoard::RankOf(const std::string& stage) const {
  return static_cast<size_t>(std::find(expected_.begin(), expected_.end(), stage) -
                             expected_.begin());
}

bool StatusBoard::IsExpected(const std::string& stage) const {
  return RankOf(stage) < expected_.size();
}

std::vector<BoardRow> StatusBoard::Rows(Clock::time_point now) const {
  std::vector<BoardRow> rows;
  std::map<std::string, int> alive;              // processes of each stage
  std::map<std::string, double> least_silent_s;  // of any process of each stage
  for (const auto& [process, heard] : heard_) {
    const bool is_losing = heard.loss && now - *heard.loss < kRecent;
    BoardRow row{.status = heard.newest,
                 .health = is_losing ? Health::kLosing : Health::kGood,
                 .is_expected = IsExpected(heard.newest.stage),
                 .silent_s = std::chrono::duration<double>(now - heard.when).count()};
    if (!heard.newest.last_error.empty()) {
      row.error_age_s = std::chrono::duration<double>(now - heard.error_since).count();
      row.error_was_there = heard.error_was_there;
    }
    if (heard.newest.state == StageStatus::State::kStopped) {
      row.health = Health::kStopped;
    } else if (now - heard.when > kStaleAfter) {
      row.health = Health::kStale;
    } else {
      ++alive[heard.newest.stage];
    }
    const auto [least, is_first] = least_silent_s.try_emplace(heard.newest.stage, row.silent_s);
    if (!is_first) least->second = std::min(least->second, row.silent_s);
    rows.push_back(std::move(row));
  }
  // A process that was replaced is of no interest any more, also when its successor has ended.
  std::erase_if(rows, [&](const BoardRow& row) {
    if (row.health != Health::kStopped && row.health != Health::kStale) return false;
    const std::string& stage = row.status.stage;
    return alive.contains(stage) || row.silent_s > least_silent_s.at(stage);
  });
  for (BoardRow& row : rows) {
    if (const auto found = alive.find(row.status.stage);
        found != alive.end() && found->second > 1) {
      row.health = Health::kTwice;
    }
  }
  for (const std::string& stage : expected_) {
    const bool heard = std::any_of(rows.begin(), rows.end(),
                                   [&](const BoardRow& row) { return row.status.stage == stage; });
    if (heard) continue;
    BoardRow& row = rows.emplace_back();
    row.status.stage = stage;
    row.is_expected = true;
  }
  std::stable_sort(rows.begin(), rows.end(), [this](const BoardRow& a, const BoardRow& b) {
    const auto rank = [this](const BoardRow& row) { return RankOf(row.status.stage); };
    return std::pair(rank(a), a.status.stage) < std::pair(rank(b), b.status.stage);
  });
  return rows;
}

bool IsWhole(const std::vector<BoardRow>& rows) {
  return std::all_of(rows.begin(), rows.end(), [](const BoardRow& row) {
    return !row.is_expected || row.health == Health::kGood || row.health == Health::kLosing;
  });
}

std::string_view NameOf(Health health) { return LookOf(health).name; }

std::string BoardText(const std::vector<BoardRow>& rows, bool colour) {
  std::string text =
      "stage      health    frame     Hz answered   time    p99    age    p99   skip  incpl  gaps  "
      "fail   bad  MB/rss   ToF  host:pid\n";
  for (const BoardRow& row : rows) text += RowText(row, rows, colour);
  text += HostsText(rows);
  if (const std::string differ = ConfigurationsText(rows); !differ.empty()) text += differ + "\n";
  for (const BoardRow& row : rows) {
    if (!IsHeard(row)) continue;
    text += CameraText(row.status);
    text += ErrorText(row);
  }
  return text;
}

std::string LeftOutText(const LeftOut& left_out) {
  std::string text;
  if (left_out.unreadable > 0) {
    text += fmt::format("{} statuses could not be read\n", left_out.unreadable);
  }
  if (left_out.no_room > 0) {
    text += fmt::format("{} statuses of further processes are not shown: there is room for {}\n",
                        left_out.no_room, StatusBoard::kMaxProcesses);
  }
  if (left_out.not_joined > 0) {
    text += fmt::format(
        "{} times this host could not join the packets of a datagram: packets are lost, or "
        "net.ipv4.ipfrag_high_thresh is too small\n",
        left_out.not_joined);
  }
  return text;
}

std::string BoardJson(const std::vector<BoardRow>& rows, const std::optional<LeftOut>& left_out) {
  nlohmann::ordered_json stages = nlohmann::ordered_json::array();
  for (const BoardRow& row : rows) {
    const StageStatus& s = row.status;
    nlohmann::ordered_json stage{{"stage", s.stage}, {"health", NameOf(row.health)}};
    if (IsHeard(row)) {
      stage.update({{"host", s.host},
                    {"pid", s.pid},
                    {"version", s.version},
                    {"config_digest", s.config_digest},
                    {"silent_s", row.silent_s},
                    {"newest_seq", s.newest_frame.seq},
                    {"newest_utime", s.newest_frame.utime},
                    {"frames_in", s.frames_in},
                    {"frames_out", s.frames_out},
                    {"frames_skipped", s.frames_skipped},
                    {"frames_incomplete", s.frames_incomplete},
                    {"frames_degenerate", s.frames_degenerate},
                    {"frames_failed", s.frames_failed},
                    {"frames_resent", s.frames_resent},
                    {"bad_messages", s.bad_messages},
                    {"sequence_gaps", s.sequence_gaps},
                    {"rate_hz", s.rate_hz},
                    {"latency_p50_ms", s.latency.p50_ms},
                    {"latency_p99_ms", s.latency.p99_ms},
                    {"age_p50_ms", s.age.p50_ms},
                    {"age_p99_ms", s.age.p99_ms},
                    {"age_clocks", ClocksOf(row, rows)},
                    {"rss_bytes", s.rss_bytes},
                    {"tof_coverage", s.tof_coverage},
                    {"spread_ms", s.spread_ms},
                    {"tof_offset_u_px", s.tof_offset.u_px},
                    {"tof_offset_v_px", s.tof_offset.v_px},
                    {"tof_offset_sigma_px", s.tof_offset.sigma_px},
                    {"last_error", s.last_error}});
      if (row.error_age_s) stage["error_age_s"] = *row.error_age_s;
    }
    stages.push_back(std::move(stage));
  }
  nlohmann::ordered_json board{{"whole", IsWhole(rows)},
                               {"configurations", ConfigurationsText(rows)}};
  if (left_out) {
    board["unreadable"] = left_out->unreadable;
    board["no_room"] = left_out->no_room;
    board["not_joined"] = left_out->not_joined;
  }
  board["stages"] = std::move(stages);
  // Names come from the network and need not be UTF-8.
  return board.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace sprout
