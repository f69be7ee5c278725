// Faults that a graph must survive unattended, one a test. Stages that are killed and stopped:
// faults.cc. A bad network: network_faults_test.cc.
#include <gmock/gmock.h>
#include <sys/stat.h>
#include <sys/syscall.h>

#include <chrono>
#include <csignal>
#include <fstream>
#include <sstream>
#include <thread>

#include "common/bus/lcm_url.h"
#include "common/logfile/log_reader.h"
#include "common/scenes/dataset.h"
#include "tests/common/picture/temporary_directory.h"
#include "tests/system/graph.h"
#include "tests/system/graph_record.h"
#include "tests/system/run_program.h"
#include "tests/system/slope.h"

namespace sprout {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr int64_t kHourUs = 3'600'000'000;
const std::string kRecord = SPROUT_SOURCE_DIR "/scripts/record";

// No clock can be set here, so frames are sent as a capture sends them whose clock is set on and
// back in the middle of the run, and which is started again.
TEST(ClockSystem, AnHourOffEitherWayLosesNothingAndIsSaid) {
  Graph graph;
  GraphRecord record(kDefaultLcmUrl);
  graph.StartChain();
  const auto source = scenes::OpenDataset("synthetic:160x120");
  int64_t sent = 0;
  const auto send = [&](int64_t seq, int64_t offset_us) {
    const scenes::DatasetFrame frame = source->Get(seq);
    const auto now = std::chrono::duration_cast<std::chrono::microseconds>(
        std::chrono::system_clock::now().time_since_epoch());
    const int64_t utime = now.count() + offset_us;
    graph.PublishFrame(utime, seq, source->rig(), frame.left, frame.right, frame.tof);
    ++sent;
    EXPECT_TRUE(record.WaitUntil([&](GraphRecord& r) {
      const auto heard = r.frames.find({utime, seq});
      return heard != r.frames.end() && heard->second.at.contains(Part::kDisparity);
    })) << "frame "
        << seq << ", clock off by " << offset_us;
  };
  for (int64_t seq = 0; seq < 5; ++seq) send(seq, 0);
  for (int64_t seq = 5; seq < 10; ++seq) send(seq, kHourUs);
  EXPECT_TRUE(graph.WaitUntil(
      [](Graph& g) { return g.statuses["grow"].last_error.find("clock") != std::string::npos; }));
  for (int64_t seq = 10; seq < 15; ++seq) send(seq, -kHourUs);
  for (int64_t seq = 0; seq < 15; ++seq) send(seq, 0);             // started again, later
  for (int64_t seq = 0; seq < 15; ++seq) send(seq, -2 * kHourUs);  // and earlier
  EXPECT_TRUE(graph.WaitUntil([&](Graph& g) { return g.statuses["grow"].frames_out == sent; }));
  graph.Look([](Graph& g) {
    for (const char* stage : kChain) {
      EXPECT_EQ(CountedLost(g.statuses[stage]), 0) << stage;
      EXPECT_LT(g.statuses[stage].age.p50_ms, 3.0 * 3'600'000) << stage;
    }
  });
  EXPECT_EQ(Objection(CompareWithPipeline(record.FramesNow(), LoadConfig({"default"})), sent), "");
}

TEST(TwoCapturesSystem, AreReportedAndNotMixed) {
  Graph graph;
  GraphRecord record(kDefaultLcmUrl);
  graph.StartChain();
  graph.Start("capture", {"--source", "synthetic:160x120", "--rate", "7"});
  // Another scene: a mixture would give other maps.
  Process second({ProgramPath("sprout-capture"), "--source", "synthetic:160x120?tof=sr4000",
                  "--rate", "5", "--config", "default"});
  EXPECT_TRUE(graph.WaitUntil([](Graph& g) {
    return g.statuses["capture"].last_error.find(
               "another sprout-capture works on these channels") != std::string::npos;
  }));
  EXPECT_TRUE(record.WaitUntil([](GraphRecord& r) {
    int64_t maps = 0;
    for (const auto& [key, heard] : r.frames) maps += heard.at.contains(Part::kDisparity);
    return maps >= 20;
  }));
  for (Process* capture : {&graph.process("capture"), &second}) {
    capture->Signal(SIGTERM);
    EXPECT_EQ(capture->Wait(), 0) << capture->Output();
    EXPECT_THAT(capture->Output(), HasSubstr("another sprout-capture works on these channels"));
  }
  EXPECT_EQ(Objection(CompareWithPipeline(record.FramesNow(), LoadConfig({"default"})), 20), "");
}

TEST(SleepingSubscriberSystem, HoldsNobodyUpAndGoesOn) {
  Graph graph;
  graph.StartChain();
  graph.Start("depth", {"--config", "default"});
  Process& depth = graph.process("depth");
  depth.Signal(SIGSTOP);
  Process& capture =
      graph.StartOnly("capture", {"--source", "synthetic:160x120", "--frames", "40", "--lockstep",
                                  "1", "--wait-for", "refine,prior,grow"});
  EXPECT_EQ(capture.Wait(), 0) << capture.Output();
  EXPECT_THAT(capture.Output(), HasSubstr("sent 40 frames"));
  EXPECT_THAT(capture.Output(), HasSubstr(", 0 again"));
  depth.Signal(SIGCONT);
  EXPECT_TRUE(graph.WaitUntil([](Graph& g) {
    const StageStatus& status = g.statuses["depth"];
    return status.newest_frame.seq == 39 && AccountedFor(status) == 40;
  }));
}

/// A file system of so many bytes that goes with the object.
class SmallDisk {
 public:
  SmallDisk(const std::filesystem::path& at, const std::string& size) : at_(at) {
    std::filesystem::create_directory(at);
    mounted_ = Run({"mount", "-t", "tmpfs", "-o", "size=" + size, "none", at_.string()});
  }
  ~SmallDisk() {
    if (mounted_) Run({"umount", "-l", at_.string()});
  }
  bool mounted() const { return mounted_; }

 private:
  static bool Run(const std::vector<std::string>& command) { return Process(command).Wait() == 0; }
  std::filesystem::path at_;
  bool mounted_ = false;
};

int64_t EventsIn(const std::filesystem::path& log) {
  LogReader reader(log);
  LogEvent event;
  int64_t events = 0;
  while (reader.Next(event)) ++events;
  return events;
}

TEST(FullDiskSystem, RecordSaysSoAndKeepsTheLog) {
  const TemporaryDirectory folder;
  const SmallDisk disk(folder / "disk", "30m");
  if (!disk.mounted()) GTEST_SKIP() << "no file system can be mounted here";
  Graph graph;
  graph.Start("capture", {"--source", "synthetic:640x480", "--rate", "10"});
  EXPECT_THAT(OutputOf({kRecord, "--dir", folder / "disk", "run"}, 1, std::chrono::seconds(60)),
              HasSubstr("No space left on device"));
  EXPECT_GT(EventsIn(folder / "disk/run.lcm"), 20);
}

TEST(FullDiskSystem, RecordDoesNotBlameACaptureThatRuns) {
  const TemporaryDirectory folder;
  const SmallDisk disk(folder / "disk", "200k");
  if (!disk.mounted()) GTEST_SKIP() << "no file system can be mounted here";
  Graph graph;
  graph.Start("capture", {"--source", "synthetic:640x480", "--rate", "10"});
  EXPECT_THAT(OutputOf({kRecord, "--dir", folder / "disk"}, 1, std::chrono::seconds(60)),
              AllOf(HasSubstr("No space left on device"), Not(HasSubstr("is capture running"))));
}

TEST(FullDiskSystem, AReplaySaysSoAndKeepsNothingUnderTheNameOfTheLog) {
  const TemporaryDirectory folder;
  const SmallDisk disk(folder / "disk", "4k");
  if (!disk.mounted()) GTEST_SKIP() << "no file system can be mounted here";
  EXPECT_THAT(
      OutputOf({"sprout-refine", "--replay", kSampleLog, "--record", folder / "disk/answers.lcm"},
               1),
      HasSubstr("cannot be written (No space left on device)"));
  EXPECT_FALSE(std::filesystem::exists(folder / "disk/answers.lcm"));
}

// Whether a process hangs in opening a file, and takes SIGINT.
bool HangsInOpen(pid_t pid) {
  return Catches(pid, SIGINT) &&
         ProcText(pid, "syscall").starts_with(std::to_string(SYS_openat) + " ");
}

// stuck_test.cc has what one signal does.
TEST(StuckSystem, ASecondCtrlCEndsAtOnceWhoHangs) {
  const TemporaryDirectory folder;
  const std::filesystem::path fifo = folder / "fifo";
  ASSERT_EQ(mkfifo(fifo.c_str(), 0600), 0);
  // A list of logs may come from another program.
  Process batch({ProgramPath("sprout-batch"), "run", "@" + fifo.string(), "--out", folder / "out"});
  ASSERT_TRUE(Eventually([&] { return HangsInOpen(batch.pid()); })) << batch.Output();
  batch.Signal(SIGINT);
  std::this_thread::sleep_for(std::chrono::milliseconds(500));  // at once it would be no other one
  batch.Signal(SIGINT);
  // By itself it would end by SIGALRM after 1.5 s.
  EXPECT_EQ(batch.Wait(), 128 + SIGINT) << batch.Output();
}

// What scripts/soak judges memory by.
TEST(Slope, IsThatOfALeakAndNotThatOfNoise) {
  std::vector<double> times_s;
  std::vector<double> leaking;
  std::vector<double> noisy;
  for (int i = 0; i < 45; ++i) {
    times_s.push_back(15 + i);
    leaking.push_back(1e8 + 1e5 * i + (i % 2) * 4096);
    noisy.push_back(1e8 + (i % 3) * 40'960);
  }
  EXPECT_NEAR(SlopeOf(times_s, leaking), 1e5, 100);
  EXPECT_NEAR(SlopeOf(times_s, noisy), 0, 1000);
}

// Local ports of the sockets in a table of /proc/net, in this network; of tcp those that listen.
std::vector<int> PortsIn(const std::string& table) {
  constexpr int kListening = 0x0a;
  std::ifstream file("/proc/self/net/" + table);
  std::string line;
  std::getline(file, line);
  std::vector<int> ports;
  while (std::getline(file, line)) {
    std::istringstream words(line);
    std::string number, local, remote, state;
    words >> number >> local >> remote >> state;
    if (table.starts_with("tcp") && std::stoi(state, nullptr, 16) != kListening) continue;
    ports.push_back(std::stoi(local.substr(local.rfind(':') + 1), nullptr, 16));
  }
  return ports;
}

TEST(TrustSystem, NothingListensOnTcpAndNothingLeavesTheHost) {
  Graph graph;
  graph.StartChain();
  graph.Start("depth");
  graph.Start("capture", {"--source", "synthetic:160x120", "--rate", "5"});
  ASSERT_TRUE(graph.WaitUntil([](Graph& g) { return g.statuses["depth"].frames_out > 0; }));
  EXPECT_THAT(PortsIn("tcp"), testing::IsEmpty());
  EXPECT_THAT(PortsIn("tcp6"), testing::IsEmpty());
  EXPECT_THAT(PortsIn("udp6"), testing::IsEmpty());
  constexpr int kFirstOfSenders = 32768;  // what the kernel gives who sends
  int listeners = 0;
  for (const int port : PortsIn("udp")) {
    if (port == 7667) {
      ++listeners;
    } else {
      EXPECT_GE(port, kFirstOfSenders);
    }
  }
  EXPECT_GE(listeners, 5);
  EXPECT_THAT(kDefaultLcmUrl, HasSubstr("?ttl=0&"));
}

}  // namespace
}  // namespace sprout
