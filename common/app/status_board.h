#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "common/core/stage_status.h"

namespace sprout {

/// State of a process of the graph, judged by its statuses.
enum class Health {
  kGood,     ///< reports, without losses
  kLosing,   ///< reports, and lost or refused something in the last kRecent
  kTwice,    ///< reports, and so does another process of the same stage
  kStale,    ///< has not reported for kStaleAfter
  kStopped,  ///< has ended
  kMissing,  ///< expected, but never heard
};

/// One process, or an expected stage that nobody has heard.
struct BoardRow {
  StageStatus status;  ///< of a missing stage only the name
  Health health = Health::kMissing;
  bool is_expected = false;  ///< its stage must be there
  double silent_s = 0;       ///< since its newest status
  /// Time since last_error was heard first; nothing if there is no error.
  std::optional<double> error_age_s = {};
  bool error_was_there = false;  ///< last_error is older than the board: the age is a least one
};

/// What is in no row.
struct LeftOut {
  int64_t unreadable = 0;  ///< messages that are no status
  int64_t no_room = 0;     ///< statuses of processes beyond StatusBoard::kMaxProcesses
  /// ReassemblyFailures() of this host since somebody listens.
  int64_t not_joined = 0;
};

/// Keeps the newest status of every process that reports, and judges them. Not thread-safe.
class StatusBoard {
 public:
  using Clock = std::chrono::steady_clock;

  /// Statuses come once a second; a late one is tolerated.
  static constexpr std::chrono::milliseconds kStaleAfter{3500};

  /// How long something that happened is shown as the present state.
  static constexpr std::chrono::seconds kRecent{60};

  /// Most processes that are kept, since anybody could send more names.
  static constexpr size_t kMaxProcesses = 64;

  /// @param expected  stages that must be there.
  explicit StatusBoard(std::vector<std::string> expected) : expected_(std::move(expected)) {}

  /// @returns whether there was room for it.
  bool Add(const StageStatus& message, Clock::time_point now);

  /// A status could not be read.
  void AddUnreadable() { ++left_out_.unreadable; }

  /// Expected stages first and in their order, then the others by name. Of a stage that runs, every
  /// process that does; of one that does not, the process that was heard last.
  std::vector<BoardRow> Rows(Clock::time_point now) const;

  const LeftOut& left_out() const { return left_out_; }

 private:
  using Process = std::tuple<std::string, std::string, int32_t>;  // stage, host, pid

  struct Heard {
    StageStatus newest;
    Clock::time_point when;
    Clock::time_point error_since;          // of newest.last_error
    bool error_was_there = false;           // with the first status
    std::optional<Clock::time_point> loss;  // the newest one that was seen
  };

  size_t RankOf(const std::string& stage) const;
  bool IsExpected(const std::string& stage) const;

  std::vector<std::string> expected_;
  std::map<Process, Heard> heard_;
  LeftOut left_out_;
};

/// Whether each expected stage reports exactly once. Others may be twice, or have ended.
bool IsWhole(const std::vector<BoardRow>& rows);

/// "good", "losing", "twice", "stale", "stopped", "missing".
std::string_view NameOf(Health health);

/// The board as lines for people: a heading, a row for each process, how configurations differ, and
/// the newest error of each process that has one.
/// @param colour  with ANSI colours for the health.
std::string BoardText(const std::vector<BoardRow>& rows, bool colour);

/// A line for people of each kind of what was left out; empty when nothing was.
std::string LeftOutText(const LeftOut& left_out);

/// The board as one line of JSON: {"whole": bool, "configurations": how those of refine, prior and
/// grow differ, "" if they do not, "unreadable": ..., "no_room": ..., "not_joined": ..., "stages":
/// [{"stage": ..., "health": ..., and the fields of stage_status_t that are numbers or texts}]}.
/// @param left_out  nothing: it is not known, and the three numbers are not there.
std::string BoardJson(const std::vector<BoardRow>& rows,
                      const std::optional<LeftOut>& left_out = {});

}  // namespace sprout
