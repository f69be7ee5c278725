#include "common/app/status_board.h"

#include <algorithm>

#include "common/core/printable.h"

namespace sprout {
namespace {

// Frames and messages that a process did not use.
int64_t Losses(const StageStatus& status) {
  return status.frames_skipped + status.frames_incomplete + status.frames_failed +
         status.frames_degenerate + status.bad_messages + status.sequence_gaps;
}

}  // namespace

bool StatusBoard::Add(const StageStatus& message, Clock::time_point now) {
  // Whoever sends a status must not move the terminal's cursor.
  StageStatus status = message;
  for (std::string* text : {&status.stage, &status.host, &status.last_error}) {
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
    ++bad_;
    return false;
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

std::vector<BoardRow> StatusBoard::Rows(Clock::time_point now) const {
  std::vector<BoardRow> rows;
  std::map<std::string, int> alive;  // processes of each stage
  for (const auto& [process, heard] : heard_) {
    const bool is_losing = heard.loss && now - *heard.loss < kRecent;
    BoardRow row{.status = heard.newest,
                 .health = is_losing ? Health::kLosing : Health::kGood,
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
    rows.push_back(std::move(row));
  }
  // A process that was replaced is of no interest any more.
  std::erase_if(rows, [&](const BoardRow& row) {
    const bool gone = row.health == Health::kStopped || row.health == Health::kStale;
    return gone && alive.contains(row.status.stage);
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
    rows.emplace_back().status.stage = stage;
  }
  std::stable_sort(rows.begin(), rows.end(), [this](const BoardRow& a, const BoardRow& b) {
    const auto rank = [this](const BoardRow& row) { return RankOf(row.status.stage); };
    return std::pair(rank(a), a.status.stage) < std::pair(rank(b), b.status.stage);
  });
  return rows;
}

bool IsWhole(const std::vector<BoardRow>& rows) {
  return std::all_of(rows.begin(), rows.end(), [](const BoardRow& row) {
    return row.health == Health::kGood || row.health == Health::kLosing;
  });
}

}  // namespace sprout
