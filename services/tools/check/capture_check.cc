#include <fmt/core.h>

#include <algorithm>
#include <iostream>
#include <optional>

#include "common/bus/receiver.h"
#include "services/tools/check/capture_listener.h"
#include "services/tools/check/checks.h"
#include "services/tools/check/program_check.h"

namespace sprout::check {
namespace {

using std::chrono::milliseconds;
using Clock = CaptureListener::Clock;

constexpr int kFrames = 10;  // at least so many are checked
constexpr milliseconds kMinTime{kMaxRigSilence + milliseconds(1000)};  // shows a missing RIG

double Seconds(milliseconds time) { return std::chrono::duration<double>(time).count(); }

// The steps of a check.
class CaptureCheck {
 public:
  CaptureCheck(const CheckOptions& options, BusConnection& bus, Process& process, Findings& found)
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

  const CheckOptions& options_;
  BusConnection& bus_;
  Process& process_;
  Findings& found_;
  CaptureListener listener_;
  bool ended_ = false;
};

}  // namespace

int CheckCapture(const CheckOptions& options) {
  BusConnection bus(options.lcm_url);
  return CheckProgram(
      options.command, options.lcm_url, kCaptureRules,
      [&](Process& process, Findings& found) {
        return CaptureCheck(options, bus, process, found).Run();
      },
      std::cout);
}

}  // namespace sprout::check
