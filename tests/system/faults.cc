// Kills and stops every process of a running graph in turn; scripts/faults says how to call it, and
// README.md here what must hold.
#include <fmt/core.h>

#include <array>
#include <chrono>
#include <csignal>
#include <iostream>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <thread>

#include "common/app/process.h"
#include "common/bus/lcm_url.h"
#include "common/config/config.h"
#include "tests/system/graph.h"
#include "tests/system/graph_record.h"
#include "tests/system/seeded_run.h"

namespace sprout {
namespace {

using Clock = GraphRecord::Clock;
using std::chrono::milliseconds;

constexpr milliseconds kStopTime{2000};
constexpr milliseconds kRestartDelay{100};    // a supervisor's
constexpr milliseconds kBackWithin{2000};     // of its return, the graph delivers
constexpr milliseconds kStartTime{30'000};    // of a process, on a busy machine
constexpr milliseconds kBalanceTime{10'000};  // for the statuses that say what became of all frames

/// What a stage answers a frame with.
struct Stage {
  const char* name;
  Part answer;
};
constexpr std::array<Stage, 4> kStages = {
    Stage{"refine", Part::kSeeds}, Stage{"prior", Part::kPrior}, Stage{"grow", Part::kDisparity},
    Stage{"depth", Part::kDepth}};
constexpr Part kLast = Part::kDepth;

/// A process, from its start.
struct Life {
  std::unique_ptr<Process> process;
  StageStatus balanced;        ///< when all was accounted for last
  size_t sent_at_start = 0;    ///< frames of this round that were sent before it was started
  size_t sent_when_ready = 0;  ///< and before its first status
};

/// What became of the frames that a stage was to answer, over all its lives.
struct Account {
  int64_t answered = 0;
  int64_t skipped = 0;
  int64_t incomplete = 0;
  int64_t gaps = 0;
  int64_t failed = 0;
  int64_t gone = 0;  ///< with a process that was killed, and between it and the next
};

int64_t Milliseconds(Clock::duration time) {
  return std::chrono::duration_cast<milliseconds>(time).count();
}

class FaultRun {
 public:
  explicit FaultRun(uint32_t seed) : random_(seed) {
    for (const Stage& stage : kStages) Start(stage.name, {"--config", "default"});
  }

  void Run(int count) {
    std::cout << fmt::format("{:>4}  {:<8} {:<8} {:>14} {:>22}\n", "", "process", "fault", "at, ms",
                             "delivers again, ms");
    for (int i = 0; i < count; ++i) {
      const size_t victim = static_cast<size_t>(i) % (kStages.size() + 1);
      const bool kill = (static_cast<size_t>(i) / (kStages.size() + 1)) % 2 == 0;
      Round(i, victim < kStages.size() ? kStages[victim].name : "capture", kill);
    }
  }

  void Print(std::ostream& out) const {
    out << fmt::format("\n{:<8} {:>6} {:>9} {:>8} {:>11} {:>6} {:>7} {:>6}\n", "stage", "sent",
                       "answered", "skipped", "incomplete", "gaps", "failed", "gone");
    for (const Stage& stage : kStages) {
      const Account& a = accounts_.contains(stage.name) ? accounts_.at(stage.name) : Account{};
      out << fmt::format("{:<8} {:>6} {:>9} {:>8} {:>11} {:>6} {:>7} {:>6}\n", stage.name, sent_,
                         a.answered, a.skipped, a.incomplete, a.gaps, a.failed, a.gone);
    }
    out << fmt::format(
        "\n{} maps, {} of them wrong, {} without their whole input\n"
        "delivers again after at most {} ms (stopped), {} ms (killed, from its first status), "
        "{} ms (from its start)\n",
        comparison_.maps, comparison_.wrong, comparison_.unknown, most_stopped_ms_, most_killed_ms_,
        most_started_ms_);
  }

 private:
  void Start(const std::string& name, std::vector<std::string> flags) {
    flags.insert(flags.begin(), {ProgramPath("sprout-" + name), "--lcm-url", kDefaultLcmUrl});
    Life& life = lives_[name];
    life = Life{.process = nullptr, .balanced = {}, .sent_at_start = record_.SentNow()};
    life.process = std::make_unique<Process>(flags);
    const pid_t pid = life.process->pid();
    if (!record_.WaitUntil(
            [&](GraphRecord& r) {
              life.sent_when_ready = r.sent.size();
              return r.statuses.contains(pid);
            },
            kStartTime)) {
      throw Failure(name + " does not start:\n" + life.process->Output());
    }
  }

  void StartCapture() {
    Start("capture", {"--config", "default", "--source", "synthetic:160x120", "--rate", "10"});
  }

  /// Time until a frame that was captured after `since` has passed all stages.
  Clock::duration WaitForDelivery(Clock::time_point since, milliseconds timeout) {
    std::optional<Clock::time_point> delivered;
    record_.WaitUntil(
        [&](GraphRecord& r) {
          for (auto key = r.sent.rbegin(); key != r.sent.rend() && !delivered; ++key) {
            const auto& at = r.frames.at(*key).at;
            if (at.begin()->second < since && at.contains(Part::kLeft)) break;
            if (at.contains(kLast)) delivered = at.at(kLast);
          }
          return delivered.has_value();
        },
        timeout);
    if (!delivered) throw Failure("nothing is delivered any more");
    return *delivered - since;
  }

  void Round(int number, const std::string& name, bool kill) {
    record_.Now([](GraphRecord& r) {
      r.frames.clear();
      r.sent.clear();
    });
    for (auto& [stage, life] : lives_) life.sent_at_start = life.sent_when_ready = 0;
    StartCapture();
    WaitForDelivery(Clock::now(), kStartTime);
    const int after_ms = std::uniform_int_distribution(100, 1100)(random_);
    std::this_thread::sleep_for(milliseconds(after_ms));
    std::cout << fmt::format("{:>4}  {:<8} {:<8} {:>14}", number + 1, name,
                             kill ? "killed" : "stopped", after_ms)
              << std::flush;
    std::optional<StageStatus> last_status;
    kill ? static_cast<void>(last_status = Kill(name)) : Stop(name);
    EndCapture();
    Balance(name, last_status);
    Compare();
  }

  void Stop(const std::string& name) {
    Process& process = *lives_.at(name).process;
    process.Signal(SIGSTOP);
    std::this_thread::sleep_for(kStopTime);
    process.Signal(SIGCONT);
    const auto took = WaitForDelivery(Clock::now(), kStartTime);
    most_stopped_ms_ = std::max(most_stopped_ms_, Milliseconds(took));
    std::cout << fmt::format(" {:>22}\n", Milliseconds(took));
    if (took > kBackWithin) throw Failure("too late");
  }

  /// @returns the last status that was heard of it.
  StageStatus Kill(const std::string& name) {
    Process& process = *lives_.at(name).process;
    const pid_t pid = process.pid();
    process.Signal(SIGKILL);
    process.Wait();
    std::this_thread::sleep_for(kRestartDelay);
    const StageStatus last_status = record_.Now([&](GraphRecord& r) { return r.statuses.at(pid); });
    const StageStatus balanced = lives_.at(name).balanced;
    const auto started = Clock::now();
    name == "capture" ? StartCapture() : Start(name, {"--config", "default"});
    const auto ready = Clock::now();
    const auto from_start = Milliseconds(WaitForDelivery(started, kStartTime));
    const auto from_ready = std::max<int64_t>(from_start - Milliseconds(ready - started), 0);
    most_started_ms_ = std::max(most_started_ms_, from_start);
    most_killed_ms_ = std::max(most_killed_ms_, from_ready);
    std::cout << fmt::format(" {:>9} of its start {:>4}\n", from_start, from_ready);
    if (milliseconds(from_ready) > kBackWithin) throw Failure("too late");
    killed_balanced_ = balanced;
    return last_status;
  }

  // After a frame that is whole.
  void EndCapture() {
    Life& life = lives_.at("capture");
    life.process->Signal(SIGTERM);
    const auto code = life.process->Wait();
    if (code != 0) throw Failure("capture does not end well:\n" + life.process->Output());
  }

  StageStatus StatusOf(GraphRecord& r, const std::string& name) {
    return r.statuses[lives_.at(name).process->pid()];
  }

  // Every frame that was sent must be answered, counted, or gone with the process that was killed.
  void Balance(const std::string& victim, const std::optional<StageStatus>& last_status) {
    // Takes the counts from the line that capture prints at its end.
    size_t sent = 0;
    const bool all_heard = record_.WaitUntil(
        [&](GraphRecord& r) {
          sent = r.sent.size();
          const StageStatus capture = StatusOf(r, "capture");
          const size_t since = lives_.at("capture").sent_at_start;
          return capture.state == StageStatus::State::kStopped &&
                 sent == since + static_cast<size_t>(capture.frames_out);
        },
        kBalanceTime);
    if (!all_heard) throw Failure("capture counts other frames than those that were heard");
    sent_ += static_cast<int64_t>(sent);
    for (const Stage& stage : kStages) {
      const bool killed = victim == stage.name && last_status;
      BalanceStage(stage, static_cast<int64_t>(sent), killed ? last_status : std::nullopt);
    }
  }

  void BalanceStage(const Stage& stage, int64_t sent,
                    const std::optional<StageStatus>& last_status) {
    Life& life = lives_.at(stage.name);
    const StageStatus before = life.balanced;
    StageStatus now;
    const auto accounted = [&] { return AccountedFor(now) - AccountedFor(before); };
    // Of a process that was started on the way: from the first frame that it can have heard.
    const auto most = sent - static_cast<int64_t>(life.sent_at_start);
    const auto least = sent - static_cast<int64_t>(life.sent_when_ready) - 1;
    const bool balanced = record_.WaitUntil(
        [&](GraphRecord& r) {
          now = StatusOf(r, stage.name);
          const bool at_the_end =
              r.sent.back() == GraphRecord::Key{now.newest_frame.utime, now.newest_frame.seq};
          return at_the_end &&
                 (last_status ? accounted() >= least && accounted() <= most : accounted() == sent);
        },
        kBalanceTime);
    if (!balanced) {
      throw Failure(fmt::format("{}: of {} frames it has accounted for {}: {}", stage.name, sent,
                                accounted(), AccountText(now, before)));
    }
    if (now.bad_messages > 0) throw Failure(fmt::format("{}: {}", stage.name, now.last_error));
    Add(stage, before, now);
    if (last_status) AddKilled(stage, *last_status, sent - accounted());
    life.balanced = now;
  }

  void Add(const Stage& stage, const StageStatus& before, const StageStatus& now) {
    Account& account = accounts_[stage.name];
    account.answered += now.frames_out - before.frames_out;
    account.skipped += now.frames_skipped - before.frames_skipped;
    account.incomplete += now.frames_incomplete - before.frames_incomplete;
    account.gaps += now.sequence_gaps - before.sequence_gaps;
    account.failed += now.frames_failed - before.frames_failed;
  }

  // Accounts for the frames before the first one of the new process: answered (heard here), counted
  // in the last status of the old one, or lost with it. Lost ones were all sent after that status.
  void AddKilled(const Stage& stage, const StageStatus& last_status, int64_t frames) {
    int64_t answered = 0;
    int64_t untold = 0;
    record_.Now([&](GraphRecord& r) {
      const GraphRecord::Key told{last_status.newest_frame.utime, last_status.newest_frame.seq};
      for (int64_t i = 0; i < frames; ++i) {
        const GraphRecord::Key& key = r.sent[static_cast<size_t>(i)];
        answered += r.frames.at(key).at.contains(stage.answer);
        untold += told < key;
      }
    });
    const int64_t gone =
        frames - answered - (CountedLost(last_status) - CountedLost(killed_balanced_));
    if (gone < 0 || gone > untold) {
      throw Failure(fmt::format("{}: {} frames are gone, of {} after its last status", stage.name,
                                gone, untold));
    }
    StageStatus told = last_status;
    told.frames_out = killed_balanced_.frames_out + answered;
    Add(stage, killed_balanced_, told);
    accounts_[stage.name].gone += gone;
  }

  void Compare() {
    const Comparison now = CompareWithPipeline(record_.FramesNow(), config_);
    comparison_.maps += now.maps;
    comparison_.wrong += now.wrong;
    comparison_.unknown += now.unknown;
    if (const std::string wrong = Objection(now, 0); !wrong.empty()) throw Failure(wrong);
  }

  std::mt19937 random_;
  SproutConfig config_ = LoadConfig({"default"});
  GraphRecord record_{kDefaultLcmUrl};
  std::map<std::string, Life> lives_;
  StageStatus killed_balanced_;  // of the process that was killed last
  std::map<std::string, Account> accounts_;
  Comparison comparison_;
  int64_t sent_ = 0;
  int64_t most_stopped_ms_ = 0;
  int64_t most_killed_ms_ = 0;
  int64_t most_started_ms_ = 0;
};

int Main(int argc, char** argv) {
  return RunSeeded<int>(argc, argv, "faults COUNT", "all survived, every frame is accounted for",
                        [](uint32_t seed) { return FaultRun(seed); });
}

}  // namespace
}  // namespace sprout

int main(int argc, char** argv) { return sprout::Main(argc, argv); }
