// A hostile sender: everything that can be wrong, on every channel, to every process, and damaged
// logs; after each burst a good frame must be answered. scripts/attack says how to call it.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <condition_variable>
#include <fstream>
#include <iostream>
#include <iterator>
#include <map>
#include <memory>
#include <mutex>
#include <random>
#include <set>

#include "common/app/process.h"
#include "common/bus/channels.h"
#include "common/bus/lcm_url.h"
#include "common/bus/publisher.h"
#include "common/bus/receiver.h"
#include "common/messages/codec.h"
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
constexpr seconds kReplayTime{120};
constexpr char kCapturePrefix[] = "ATTACKED_";

// Unfinished frames (1 GiB), messages that wait (512 MB), and two frames of the largest size that
// is sent here, being decoded and worked on (0.5 GB).
constexpr int64_t kMaxMegabytes = 2048;

std::string Program(const std::string& name) {
  return (std::filesystem::path(SPROUT_BINARY_DIR) / ("sprout-" + name)).string();
}

// Peak of its memory, MB.
int64_t PeakMegabytes(pid_t pid) {
  std::ifstream status(fmt::format("/proc/{}/status", pid));
  for (std::string word; status >> word;) {
    if (word != "VmHWM:") continue;
    int64_t kilobytes = 0;
    status >> kilobytes;
    return kilobytes / 1024;
  }
  return 0;
}

// What the attacked processes say.
class Ear {
 public:
  Ear()
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
  Attack(const check::TestFrame& good, uint32_t seed) : hostile_(good, seed), random_(seed) {
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
      if (rounds_++ % 4 == 0) ReadDamagedLog();
    } while (Clock::now() < end);
    RequireCounts();
  }

  void RequireReady() {
    for (const auto& [name, target] : targets_) {
      const pid_t pid = target.process->pid();
      if (!ear_.WaitUntil(kAnswerTime, [&](Ear& ear) { return ear.heard.contains(pid); })) {
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
    out << fmt::format("{:<28} {:>9}\n{:<28} {:>9}\n{:<28} {:>9}\n\n", "all of them", sum,
                       "good frames answered", rounds_, "damaged logs read", logs_);
    out << fmt::format("{:<10} {:>14} {:>14} {:>9}\n", "process", "surely bad", "counted bad",
                       "peak, MB");
    for (const auto& [name, target] : targets_) {
      const pid_t pid = target.process->pid();
      int64_t counted = 0;
      ear_.WaitUntil(seconds(0), [&](Ear& ear) {
        counted = ear.heard[pid].bad_messages;
        return true;
      });
      out << fmt::format("{:<10} {:>14} {:>14} {:>9}\n", name, target.bad_sent, counted,
                         PeakMegabytes(pid));
    }
  }

 private:
  struct Folder {
    Folder() {
      std::string name = std::filesystem::temp_directory_path() / "sprout_attack_XXXXXX";
      path = mkdtemp(name.data());
    }
    ~Folder() { std::filesystem::remove_all(path); }
    std::filesystem::path path;
  };

  void Start(const std::string& name, std::vector<std::string> flags, const PartSet& parts) {
    flags.insert(flags.begin(), {Program(name), "--lcm-url", Ear::Url()});
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
        const auto has_answer = [&](Ear& ear) { return ear.answered.contains(seq); };
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
    const bool goes_on = ear_.WaitUntil(kAnswerTime, [&](Ear& ear) {
      captured = std::move(ear.captured);
      ear.captured.clear();
      return !captured.empty();
    });
    RequireAlive();
    if (!goes_on) throw Failure("capture sends nothing any more");
    for (const auto& [seq, id] : captured) {
      Send(capture_publisher_, {"good answers to capture", std::string(ChannelOf(Part::kDisparity)),
                                EncodePart(id, Part::kDisparity, DisparityImage(cv::Size(64, 48)),
                                           DisparityEncoding::kRawInt16),
                                false});
    }
  }

  // Statuses come once a second; of large messages some may be lost.
  void RequireCounts() {
    for (const auto& [name, target] : targets_) {
      const pid_t pid = target.process->pid();
      const bool counted = ear_.WaitUntil(seconds(10), [&, least = target.bad_sent / 2](Ear& ear) {
        return ear.heard[pid].bad_messages >= least;
      });
      if (!counted) throw Failure(name + " has not counted its bad messages");
      const int64_t peak = PeakMegabytes(pid);
      if (peak > kMaxMegabytes) throw Failure(fmt::format("{} took {} MB", name, peak));
    }
  }

  void ReadDamagedLog() {
    const std::string log = folder_.path / "damaged.lcm";
    const std::vector<char> bytes = DamagedLog();
    std::ofstream(log, std::ios::binary)
        .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    const std::array<std::string, 3> stages = {"refine", "prior", "grow"};
    const std::string& stage = stages[random_() % stages.size()];
    RequireEnds({Program(stage), "--replay", log, "--record", folder_.path / "answers.lcm"});
    RequireEnds({Program("log"), "info", log});
    RequireEnds({Program("log"), "repair", log, folder_.path / "repaired.lcm", "--force"});
    ++logs_;
  }

  void RequireEnds(const std::vector<std::string>& command) {
    constexpr int kLargestExitCode = 2;  // what is larger is a signal
    Process process(command);
    const auto code = process.Wait(kReplayTime);
    if (code && *code <= kLargestExitCode) return;
    throw Failure(fmt::format("{}: {}\n{}", fmt::join(command, " "),
                              code ? fmt::format("exit code {}", *code) : "does not end",
                              process.Output()));
  }

  // The sample log with bytes changed, stretches overwritten, taken out and doubled, and an end.
  std::vector<char> DamagedLog() {
    std::ifstream file(kSampleLog, std::ios::binary);
    std::vector<char> bytes(std::istreambuf_iterator<char>(file), {});
    const auto below = [&](size_t end) { return random_() % std::max<size_t>(end, 1); };
    const auto at = [&](size_t offset) {
      return bytes.begin() + static_cast<std::ptrdiff_t>(offset);
    };
    for (size_t i = 1 + below(20); i > 0; --i) {
      const size_t begin = below(bytes.size());
      const size_t count = below(std::min<size_t>(bytes.size() - begin, 20'000));
      const std::vector<char> stretch(at(begin), at(begin + count));
      switch (below(5)) {
        case 0:
          std::generate(at(begin), at(begin + count), [&] { return static_cast<char>(random_()); });
          break;
        case 1:
          bytes.erase(at(begin), at(begin + count));
          break;
        case 2:
          bytes.insert(at(below(bytes.size())), stretch.begin(), stretch.end());
          break;
        case 3:
          bytes.resize(bytes.size() - below(bytes.size() / 10));
          break;
        default:
          for (size_t k = below(100); k > 0; --k)
            *at(below(bytes.size())) ^= static_cast<char>(random_());
      }
    }
    return bytes;
  }

  HostileMessages hostile_;
  std::mt19937 random_;
  Folder folder_;
  Ear ear_;
  Publisher publisher_{Ear::Url(), ""};
  Publisher capture_publisher_{Ear::Url(), kCapturePrefix};
  std::map<std::string, Target> targets_;
  std::map<std::string, int64_t> sent_;  // by way
  int64_t next_good_ = 1'000'000;        // seq beyond all hostile ones but the extremes
  int64_t rounds_ = 0;
  int64_t logs_ = 0;
};

int Main(int argc, char** argv) {
  return RunSeeded<seconds>(argc, argv, "attack SECONDS", "\nall survived", [](uint32_t seed) {
    return Attack(check::ReadTestFrames(kSampleLog, check::ContractOf("grow")).at(0), seed);
  });
}

}  // namespace
}  // namespace sprout

int main(int argc, char** argv) { return sprout::Main(argc, argv); }
