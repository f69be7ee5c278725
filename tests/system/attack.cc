// A hostile sender: everything that can be wrong, on every channel, to every process; after each
// burst a good frame must be answered. scripts/attack says how to call it.
#include <fmt/core.h>

#include <chrono>
#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <set>

#include "common/app/process.h"
#include "common/bus/channels.h"
#include "common/bus/lcm_url.h"
#include "common/bus/publisher.h"
#include "common/bus/receiver.h"
#include "common/messages/codec.h"
#include "tests/system/eventually.h"
#include "tests/system/hostile_messages.h"
#include "tests/system/log_bytes.h"
#include "tests/system/seeded_run.h"

namespace sprout {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::seconds;

constexpr int kBurst = 20;          // ways of attack between two good frames
constexpr seconds kAnswerTime{60};  // a frame without sense may be large
constexpr int kTries = 3;           // of a good frame, since LCM may lose some
constexpr char kCapturePrefix[] = "ATTACKED_";

// Unfinished frames (1 GiB), messages that wait (512 MB), and two frames of the largest size that
// is sent here, being decoded and worked on (0.5 GB).
constexpr int64_t kMaxMegabytes = 2048;

// Receives what the attacked processes send.
class Listener {
 public:
  Listener()
      : graph_(Url(), "", {ChannelOf(Part::kDisparity), kStatusChannel}, On()),
        capture_(Url(), kCapturePrefix, {ChannelOf(Part::kLeft), kStatusChannel}, On()) {}

  static const char* Url() { return kDefaultLcmUrl; }

  template <typename Condition>
  bool WaitUntil(seconds timeout, const Condition& condition) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, timeout, [&] { return condition(*this); });
  }

  // Only inside WaitUntil().
  std::set<int64_t> answered;            // by seq
  std::map<int32_t, StageStatus> heard;  // newest by process
  std::map<int64_t, FrameId> captured;   // by seq, and not answered yet

 private:
  Receiver::Handler On() {
    return [this](std::string_view channel, std::span<const uint8_t> bytes) {
      Hear(channel, bytes);
      changed_.notify_all();
    };
  }

  void Hear(std::string_view channel, std::span<const uint8_t> bytes) {
    const std::lock_guard lock(mutex_);
    if (channel == kStatusChannel) {
      if (const auto status = DecodeStatus(bytes)) heard[status->pid] = *status;
    } else if (channel == ChannelOf(Part::kLeft)) {
      if (const auto id = DecodeFrameId(bytes)) captured[id->seq] = *id;
    } else if (const auto map = DecodePart(Part::kDisparity, bytes)) {
      if (std::get<DisparityImage>(map->value).CountValid() > 0) answered.insert(map->id.seq);
    }
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  Receiver graph_;
  Receiver capture_;
};

struct Target {
  std::unique_ptr<Process> process;
  std::set<std::string, std::less<>> channels;  // that it listens to
  int64_t bad_sent = 0;                         // on these
};

class Attack {
 public:
  Attack(const check::TestFrame& good, uint32_t seed) : hostile_(good, seed) {
    Start("refine", {}, {Part::kLeft, Part::kRight, Part::kTof, Part::kRig});
    Start("prior", {}, {Part::kLeft, Part::kRight, Part::kSeeds, Part::kLeftSeeds});
    Start("grow", {}, {Part::kLeft, Part::kRight, Part::kSeeds, Part::kPrior});
    Start("capture",
          {"--source", "synthetic:64x48", "--rate", "0", "--lockstep", "2", "--wait-for",
           "attacker", "--wait-timeout", "3600", "--channel-prefix", kCapturePrefix},
          {});
    targets_.at("capture").channels = {std::string(kStatusChannel),
                                       std::string(ChannelOf(Part::kDisparity))};
  }

  void Run(seconds time) {
    RequireReady();
    const auto end = Clock::now() + time;
    do {
      for (int i = 0; i < kBurst; ++i) {
        for (const HostileMessage& message : hostile_.Next()) Send(publisher_, message);
        Send(capture_publisher_, hostile_.NextForCapture());
      }
      RequireAnswer();
      RequireCapture();
      ++rounds_;
    } while (Clock::now() < end);
    RequireCounts();
  }

  void RequireReady() {
    for (const auto& [name, target] : targets_) {
      const pid_t pid = target.process->pid();
      if (!ear_.WaitUntil(kAnswerTime, [&](Listener& ear) { return ear.heard.contains(pid); })) {
        RequireAlive();
        throw Failure("no status from " + name);
      }
    }
  }

  // Throws when a process has ended.
  void RequireAlive() {
    for (const auto& [name, target] : targets_) {
      if (const auto code = target.process->Wait(seconds(0))) {
        throw Failure(
            fmt::format("{} ended with exit code {}:\n{}", name, *code, target.process->Output()));
      }
    }
  }

  void Print(std::ostream& out) {
    out << fmt::format("{:<28} {:>9}\n", "attack", "messages");
    int64_t sum = 0;
    for (const auto& [way, count] : sent_) {
      out << fmt::format("{:<28} {:>9}\n", way, count);
      sum += count;
    }
    out << fmt::format("{:<28} {:>9}\n{:<28} {:>9}\n\n", "all of them", sum, "good frames answered",
                       rounds_);
    out << fmt::format("{:<10} {:>14} {:>14} {:>9}\n", "process", "surely bad", "counted bad",
                       "peak, MB");
    for (const auto& [name, target] : targets_) {
      const pid_t pid = target.process->pid();
      int64_t counted = 0;
      ear_.WaitUntil(seconds(0), [&](Listener& ear) {
        counted = ear.heard[pid].bad_messages;
        return true;
      });
      out << fmt::format("{:<10} {:>14} {:>14} {:>9}\n", name, target.bad_sent, counted,
                         PeakMegabytes(pid));
    }
  }

 private:
  void Start(const std::string& name, std::vector<std::string> flags, const PartSet& parts) {
    flags.insert(flags.begin(), {ProgramPath("sprout-" + name), "--lcm-url", Listener::Url()});
    Target& target = targets_[name];
    target.process = std::make_unique<Process>(flags);
    for (const Part part : kAllParts) {
      if (parts.Has(part)) target.channels.emplace(ChannelOf(part));
    }
  }

  void Send(Publisher& publisher, const HostileMessage& message) {
    const bool to_capture = &publisher == &capture_publisher_;
    ++sent_[message.way];
    for (auto& [name, target] : targets_) {
      if (message.bad && (name == "capture") == to_capture &&
          target.channels.contains(message.channel)) {
        ++target.bad_sent;
      }
    }
    if (!publisher.Publish(message.channel, message.bytes)) throw Failure("publish failed");
  }

  void RequireAnswer() {
    for (int tries = 0; tries < kTries; ++tries) {
      const int64_t seq = next_good_++;
      for (const HostileMessage& message : hostile_.GoodFrame(seq)) Send(publisher_, message);
      for (auto waited = seconds(0); waited < kAnswerTime; ++waited) {
        RequireAlive();
        const auto has_answer = [&](Listener& ear) { return ear.answered.contains(seq); };
        if (ear_.WaitUntil(seconds(1), has_answer)) return;
      }
    }
    throw Failure(fmt::format("a good frame was sent {} times and never answered", kTries));
  }

  // Capture goes on when what it waits for comes.
  void RequireCapture() {
    StageStatus status;
    status.stage = "attacker";
    Send(capture_publisher_,
         {"good statuses", std::string(kStatusChannel), EncodeStatus(status), false});
    std::map<int64_t, FrameId> captured;
    const bool goes_on = ear_.WaitUntil(kAnswerTime, [&](Listener& ear) {
      captured = std::move(ear.captured);
      ear.captured.clear();
      return !captured.empty();
    });
    RequireAlive();
    if (!goes_on) throw Failure("capture sends nothing any more");
    for (const auto& [seq, id] : captured) {
      Send(capture_publisher_,
           {"good answers to capture", std::string(ChannelOf(Part::kDisparity)),
            EncodePart(id, Part::kDisparity, DisparityImage(cv::Size(64, 48))), false});
    }
  }

  // Statuses come once a second; of large messages some may be lost.
  void RequireCounts() {
    for (const auto& [name, target] : targets_) {
      const pid_t pid = target.process->pid();
      const bool counted =
          ear_.WaitUntil(seconds(10), [&, least = target.bad_sent / 2](Listener& ear) {
            return ear.heard[pid].bad_messages >= least;
          });
      if (!counted) throw Failure(name + " has not counted its bad messages");
      const int64_t peak = PeakMegabytes(pid);
      if (peak > kMaxMegabytes) throw Failure(fmt::format("{} took {} MB", name, peak));
    }
  }

  HostileMessages hostile_;
  Listener ear_;
  Publisher publisher_{Listener::Url(), ""};
  Publisher capture_publisher_{Listener::Url(), kCapturePrefix};
  std::map<std::string, Target> targets_;
  std::map<std::string, int64_t> sent_;  // by way
  int64_t next_good_ = 1'000'000;        // seq beyond all hostile ones but the extremes
  int64_t rounds_ = 0;
};

int Main(int argc, char** argv) {
  return RunSeeded<seconds>(argc, argv, "attack SECONDS", "\nall survived", [](uint32_t seed) {
    return Attack(check::ReadTestFrames(kSampleLog, check::ContractOf("grow")).at(0), seed);
  });
}

}  // namespace
}  // namespace sprout

int main(int argc, char** argv) { return sprout::Main(argc, argv); }
