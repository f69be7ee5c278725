#include <fmt/core.h>

#include <algorithm>
#include <iostream>
#include <optional>
#include <string_view>
#include <utility>

#include "common/bus/channels.h"
#include "common/config/config_error.h"
#include "common/core/image.h"
#include "common/core/joined.h"
#include "common/core/quantile.h"
#include "services/tools/check/checks.h"
#include "services/tools/check/conversation.h"
#include "services/tools/check/program_check.h"

namespace sprout::check {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kStartPeriod{300};  // a program that is not yet subscribed is asked again
constexpr milliseconds kSettle{300};       // for answers that should not come

constexpr auto kRaw = DisparityEncoding::kRawInt16;
constexpr auto kCompressed = DisparityEncoding::kDeltaZstd;

// The steps of a check.
class StageCheck {
 public:
  StageCheck(const CheckOptions& options, const StageContract& contract,
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
    constexpr std::pair<Part, std::string_view> kMissed[] = {
        {Part::kLeftSeeds, "the prior behind it prior { left_seeds: false }"},
        {Part::kConfidence, "sprout-depth depth { confidence: false }"}};
    for (const auto& [part, cure] : kMissed) {
      if (!contract_.may_publish.Has(part) || talk_.extras_heard().Has(part)) continue;
      figures +=
          fmt::format("{}: nothing on {}: give {}\n", contract_.stage, ChannelOf(part), cure);
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
      talk_.Ask(frames_[0], kRaw, AnswerCheck::kIfAnswered, Rule::kStart, kStartPeriod);
      started_ = talk_.answers_heard() > 0;
    }
    if (!started_ && !talk_.over()) {
      found_.Add(
          Rule::kStart,
          fmt::format("no answer on {} within {} s; {}", ChannelOf(contract_.answer),
                      std::chrono::duration<double>(options_.start_timeout).count(), WhyNone()));
    }
  }

  std::string WhyNone() const {
    const auto& others = talk_.others_heard();
    if (others.empty()) return "does it listen on " + options_.lcm_url + "?";
    return "it publishes on " + Joined(", ", std::vector(others.begin(), others.end()));
  }

  // Whether the stage's status says that every frame failed: asking on would not help, and the
  // messages do arrive.
  bool EveryFrameFailed() const {
    constexpr int64_t kEnough = 3;
    const auto& status = talk_.newest_status();
    return status && status->frames_out == 0 && status->frames_failed >= kEnough;
  }

  std::optional<PartValue> Ask(const TestFrame& frame, DisparityEncoding maps, AnswerCheck check,
                               Rule rule) {
    return talk_.Ask(frame, maps, check, rule, options_.answer_timeout);
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
      answers_.push_back(Ask(frame, kRaw, AnswerCheck::kAll, Rule::kOneAnswer));
      if (talk_.over()) return;
      if (!answers_.back() || !frame.recorded) continue;
      comparable_.push_back(*answers_.back());
      recorded_.push_back(*frame.recorded);
    }
    // This finds a program that sends its first map again and again.
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
      const auto answer = Ask(frames_[i], kRaw, AnswerCheck::kAll, Rule::kOneAnswer);
      if (answer && answers_[i] && !IsSameAnswer(*answer, *answers_[i])) {
        repeatable_ = false;
        found_.Add(Rule::kRepeatable, frames_[i].name + ": another answer than the first time");
      }
    }
  }

  // Other forms that capture and earlier stages may send: LEFT in grey, compressed maps.
  void OtherForms() {
    TestFrame grey = frames_[0];
    grey.name += " with LEFT in grey";
    PartValue& left = grey.parts.at(Part::kLeft);
    left = cv::Mat(ToGrey(std::get<cv::Mat>(left)));
    Ask(grey, kRaw, AnswerCheck::kAll, Rule::kOneAnswer);
    if (!frames_[0].parts.contains(Part::kPrior)) return;
    ForgetFrames();
    TestFrame compressed = frames_[0];
    compressed.name += " with compressed maps";
    Ask(compressed, kCompressed, AnswerCheck::kAll, Rule::kOneAnswer);
  }

  void Poor() {
    found_.Checked(Rule::kDegenerate);
    for (const TestFrame& frame : DegenerateFrames(frames_[0])) {
      Ask(frame, kRaw, AnswerCheck::kForm, Rule::kDegenerate);
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
        const auto answer = Ask(good, kRaw, AnswerCheck::kAll, Rule::kBadMessages);
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

  const CheckOptions& options_;
  const StageContract& contract_;
  const std::vector<TestFrame>& frames_;
  Process& process_;
  Findings& found_;
  Conversation talk_;
  bool started_ = false;
  bool repeatable_ = true;
  std::vector<std::optional<PartValue>> answers_;  // to frames_
  std::vector<PartValue> comparable_;              // answers to frames with a recorded answer
  std::vector<PartValue> recorded_;
};

}  // namespace

int CheckStage(const CheckOptions& options) {
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

}  // namespace sprout::check
