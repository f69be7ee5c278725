#include <fmt/core.h>

#include <algorithm>
#include <iostream>

#include "common/app/program.h"
#include "common/bus/channels.h"
#include "common/bus/lcm_url.h"
#include "common/bus/receiver.h"
#include "common/config/config_error.h"
#include "common/core/image.h"
#include "common/core/quantile.h"
#include "services/tools/check/capture_listener.h"
#include "services/tools/check/conversation.h"
#include "services/tools/check/program_check.h"

namespace sprout::check {
namespace {

using std::chrono::milliseconds;

struct StageCheckOptions {
  std::string stage;  // "capture", or a StageContract's
  std::vector<std::string> command;
  std::string log;
  std::string lcm_url = kDefaultLcmUrl;
  milliseconds start_timeout{};
  milliseconds answer_timeout{};
};

constexpr milliseconds kStartPeriod{300};  // a program that is not yet subscribed is asked again
constexpr milliseconds kSettle{300};       // for answers that should not come

constexpr auto kRaw = DisparityEncoding::kRawInt16;
constexpr auto kCompressed = DisparityEncoding::kDeltaZstd;

// The course of a check.
class StageCheck {
 public:
  StageCheck(const StageCheckOptions& options, const StageContract& contract,
             const std::vector<TestFrame>& frames, BusConnection& bus, Process& process,
             Findings& found)
      : options_(options),
        contract_(contract),
        frames_(frames),
        process_(process),
        found_(found),
        talk_(contract_, bus, process, found) {}

  void Run() {
    Start();
    if (started_) GoodFrames();
    // If a program leaves good frames unanswered, the remaining steps would show nothing.
    if (started_ && talk_.frames_missed() == 0) {
      for (const auto step :
           {&StageCheck::Again, &StageCheck::OtherForms, &StageCheck::Poor, &StageCheck::Bad}) {
        if (!talk_.over()) (this->*step)();
      }
    }
    talk_.Listen(kSettle);
    if (started_) End();
  }

  std::string Figures() const {
    std::vector<double> times = talk_.times_ms();
    if (times.empty()) return "";
    const double longest = *std::ranges::max_element(times);  // Median() reorders
    std::string figures = fmt::format(
        "{0}: {1:.1f} ms a frame in the median, {2:.1f} ms at most, over {3} frames of {4}\n"
        "{0}: {5}\n",
        contract_.stage, Median(times), longest, times.size(),
        SizeText(frames_[0].rig().pair.size()), CompareAnswers(comparable_, recorded_));
    if (contract_.may_publish.Has(Part::kLeftSeeds) &&
        !talk_.extras_heard().Has(Part::kLeftSeeds)) {
      figures +=
          fmt::format("{}: nothing on {}: give the prior behind it prior {{ left_seeds: false }}\n",
                      contract_.stage, ChannelOf(Part::kLeftSeeds));
    }
    return figures;
  }

 private:
  // There is no other sign of readiness than an answer: asks until one comes.
  void Start() {
    found_.Checked(Rule::kStart);
    const auto deadline = Conversation::Clock::now() + options_.start_timeout;
    while (!started_ && !talk_.over() && Conversation::Clock::now() < deadline) {
      if (EveryFrameFailed()) {
        const StageStatus& status = *talk_.newest_status();
        found_.Add(Rule::kStart, fmt::format("no answer: all of {} frames failed, the newest: {}",
                                             status.frames_failed, status.last_error));
        return;
      }
      talk_.Ask(frames_[0], kRaw, Look::kIfAnswered, Rule::kStart, kStartPeriod);
      started_ = talk_.answers_heard() > 0;
    }
    if (!started_ && !talk_.over()) {
      found_.Add(Rule::kStart,
                 fmt::format("no answer within {} s; does it listen on {}?",
                             std::chrono::duration<double>(options_.start_timeout).count(),
                             options_.lcm_url));
    }
  }

  // Whether the stage's status says that every frame failed: asking on would not help, and the
  // messages do arrive.
  bool EveryFrameFailed() const {
    constexpr int64_t kEnough = 3;
    const auto& status = talk_.newest_status();
    return status && status->frames_out == 0 && status->frames_failed >= kEnough;
  }

  std::optional<PartValue> Ask(const TestFrame& frame, DisparityEncoding maps, Look look,
                               Rule rule) {
    return talk_.Ask(frame, maps, look, rule, options_.answer_timeout);
  }

  // Makes a stage with memory forget all frames, by a gap in time.
  void ForgetFrames() {
    if (contract_.has_memory) talk_.LetTimePass();
  }

  void GoodFrames() {
    for (const Rule rule :
         {Rule::kOneAnswer, Rule::kHeader, Rule::kForm, Rule::kValues, Rule::kChannels}) {
      found_.Checked(rule);
    }
    ForgetFrames();
    for (const TestFrame& frame : frames_) {
      answers_.push_back(Ask(frame, kRaw, Look::kAll, Rule::kOneAnswer));
      if (talk_.over()) return;
      if (!answers_.back() || !frame.recorded) continue;
      comparable_.push_back(*answers_.back());
      recorded_.push_back(*frame.recorded);
    }
    // As of a program that sends its first map again and again.
    if (AreAllTheSame(comparable_) && !AreAllTheSame(recorded_)) {
      found_.Add(Rule::kValues, fmt::format("all {} frames got the same answer; the recorded ones "
                                            "differ",
                                            comparable_.size()));
    }
  }

  void Again() {
    found_.Checked(Rule::kRepeatable);
    ForgetFrames();
    for (size_t i = 0; i < frames_.size() && !talk_.over(); ++i) {
      const auto answer = Ask(frames_[i], kRaw, Look::kAll, Rule::kOneAnswer);
      if (answer && answers_[i] && !IsSameAnswer(*answer, *answers_[i])) {
        repeatable_ = false;
        found_.Add(Rule::kRepeatable, frames_[i].name + ": another answer than the first time");
      }
    }
  }

  // What capture and the stages before may send as well: LEFT in grey, compressed maps.
  void OtherForms() {
    TestFrame grey = frames_[0];
    grey.name += " with LEFT in grey";
    PartValue& left = grey.parts.at(Part::kLeft);
    left = cv::Mat(ToGrey(std::get<cv::Mat>(left)));
    Ask(grey, kRaw, Look::kAll, Rule::kOneAnswer);
    if (!frames_[0].parts.contains(Part::kPrior)) return;
    ForgetFrames();
    TestFrame compressed = frames_[0];
    compressed.name += " with compressed maps";
    Ask(compressed, kCompressed, Look::kAll, Rule::kOneAnswer);
  }

  void Poor() {
    found_.Checked(Rule::kDegenerate);
    for (const TestFrame& frame : DegenerateFrames(frames_[0])) {
      Ask(frame, kRaw, Look::kForm, Rule::kDegenerate);
      if (talk_.over()) return;
    }
  }

  // A good frame after each bad message tells which of them did harm.
  void Bad() {
    found_.Checked(Rule::kBadMessages);
    for (const Part part : contract_.inputs) {
      for (const Corruption& corruption : CorruptionsOf(part)) {
        talk_.SendBad(frames_[0], part, corruption);
        ForgetFrames();
        TestFrame good = frames_[0];
        good.name += " after " + std::string(ChannelOf(part)) + ", " + corruption.name;
        const auto answer = Ask(good, kRaw, Look::kAll, Rule::kBadMessages);
        if (repeatable_ && answer && answers_[0] && !IsSameAnswer(*answer, *answers_[0])) {
          found_.Add(Rule::kBadMessages, good.name + ": another answer than before");
        }
        if (talk_.over()) return;
      }
    }
  }

  void End() {
    talk_.NoticeEnd(Rule::kEnd, "before it was told to");
    if (!talk_.ended()) CheckEnd(process_, found_);
  }

  const StageCheckOptions& options_;
  const StageContract& contract_;
  const std::vector<TestFrame>& frames_;
  Process& process_;
  Findings& found_;
  Conversation talk_;
  bool started_ = false;
  bool repeatable_ = true;
  std::vector<std::optional<PartValue>> answers_;  // to frames_
  std::vector<PartValue> comparable_;              // those of them to frames with a recorded one
  std::vector<PartValue> recorded_;
};

using Clock = CaptureListener::Clock;

constexpr int kFrames = 10;  // at least so many are looked at
constexpr milliseconds kMinTime{kMaxRigSilence + milliseconds(1000)};  // shows a missing RIG

double Seconds(milliseconds time) { return std::chrono::duration<double>(time).count(); }

// The course of a check.
class CaptureCheck {
 public:
  CaptureCheck(const StageCheckOptions& options, BusConnection& bus, Process& process,
               Findings& found)
      : options_(options), bus_(bus), process_(process), found_(found), listener_(found) {}

  std::string Run() {
    found_.Checked(Rule::kSends);
    if (Start()) {
      Observe();
      listener_.Finish(Clock::now());
      if (!ended_) CheckEnd(process_, found_);
    }
    return listener_.Figures();
  }

 private:
  // Whether a whole frame came in time.
  bool Start() {
    const Clock::time_point deadline = Clock::now() + options_.start_timeout;
    while (listener_.whole_frames() == 0 && Clock::now() < deadline) {
      if (!Listen(deadline, Rule::kSends, "before the first whole frame")) return false;
    }
    if (listener_.whole_frames() > 0) return true;
    found_.Add(Rule::kSends, fmt::format("no whole frame within {} s; heard on {}: {}",
                                         Seconds(options_.start_timeout), options_.lcm_url,
                                         listener_.HeardChannels()));
    return false;
  }

  void Observe() {
    for (const Rule rule : kCaptureRules) {
      if (rule != Rule::kEnd) found_.Checked(rule);
    }
    const Clock::time_point start = Clock::now();
    Clock::time_point newest = start;
    while (listener_.whole_frames() < kFrames || Clock::now() < start + kMinTime) {
      const int before = listener_.whole_frames();
      if (!Listen(newest + options_.answer_timeout, Rule::kEnd,
                  "before it was told to, after " + std::to_string(before) + " frames")) {
        return;
      }
      if (listener_.whole_frames() > before) newest = Clock::now();
      if (Clock::now() < newest + options_.answer_timeout) continue;
      found_.Add(Rule::kWhole, fmt::format("no whole frame for {} s after {} of them",
                                           Seconds(options_.answer_timeout), before));
      return;
    }
  }

  // Takes one message, or none for a while. False when the program has ended, which breaks `rule`.
  bool Listen(Clock::time_point deadline, Rule rule, const std::string& when) {
    if (const auto heard = bus_.Next(std::min(Clock::now() + kPoll, deadline))) {
      listener_.Take(*heard);
      return true;
    }
    const std::optional<std::string> how = HowItEnded(process_);
    if (!how) return true;
    ended_ = true;
    found_.Add(rule, fmt::format("{}: the program {}", when, *how));
    return false;
  }

  const StageCheckOptions& options_;
  BusConnection& bus_;
  Process& process_;
  Findings& found_;
  CaptureListener listener_;
  bool ended_ = false;
};

// Starts the program, sends it frames, ends it, and prints the findings.
// @returns exit code: 0; 1 when something is wrong with the program.
int CheckStage(const StageCheckOptions& options) {
  const StageContract contract = ContractOf(options.stage);
  if (options.log.empty()) throw ConfigError("--log: a log is needed for " + options.stage);
  const std::vector<TestFrame> frames = ReadTestFrames(options.log, contract);
  BusConnection bus(options.lcm_url);
  return CheckProgram(
      options.command, options.lcm_url, kStageRules,
      [&](Process& process, Findings& found) {
        StageCheck check(options, contract, frames, bus, process, found);
        check.Run();
        return check.Figures();
      },
      std::cout);
}

// Starts a capture process, receives its messages for some seconds, and ends it. Needs no log.
int CheckCapture(const StageCheckOptions& options) {
  BusConnection bus(options.lcm_url, {Receiver::kAllChannels});
  return CheckProgram(
      options.command, options.lcm_url, kCaptureRules,
      [&](Process& process, Findings& found) {
        return CaptureCheck(options, bus, process, found).Run();
      },
      std::cout);
}

constexpr char kDescription[] =
    "Checks whether a program can replace a stage: starts it, sends it the frames of a log, "
    "and\nchecks every answer. For capture it starts the program and checks what it "
    "sends.\nscripts/check_stage runs it on a private network.";

milliseconds Milliseconds(double seconds) {
  return milliseconds(static_cast<int64_t>(seconds * 1000));
}

int Main(int argc, char** argv) {
  Flags flags("sprout-check-stage", kDescription);
  StageCheckOptions options;
  double start_s = 30;
  double answer_s = 10;
  flags.Add("STAGE", options.stage, "capture, refine, prior, grow, temporal or pipeline")
      .Required();
  flags.Add("COMMAND", options.command, "Program and its arguments, after --").Required();
  flags.Add("--log", options.log,
            "Log with every channel of the graph; needed unless STAGE is capture");
  flags
      .Add("--lcm-url", options.lcm_url,
           "A bus without other processes; the program gets it as LCM_DEFAULT_URL")
      .ShowDefault();
  flags
      .Add("--start-timeout", start_s,
           "Longest wait for the first answer, or capture's first frame, s")
      .Within(0.1, 3600.0)
      .ShowDefault();
  flags.Add("--timeout", answer_s, "Longest wait for any other answer or frame, s")
      .Within(0.01, 3600.0)
      .ShowDefault();
  return RunProgram(flags, argc, argv, [&] {
    options.start_timeout = Milliseconds(start_s);
    options.answer_timeout = Milliseconds(answer_s);
    try {
      return RefusingLogs(
          [&] { return options.stage == "capture" ? CheckCapture(options) : CheckStage(options); });
    } catch (const BusError& e) {
      throw ConfigError(e.what());
    }
  });
}

}  // namespace
}  // namespace sprout::check

int main(int argc, char** argv) { return sprout::check::Main(argc, argv); }
