#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/file.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <map>

#include "common/bus/channels.h"
#include "common/messages/codec.h"
#include "common/messages/packed.h"
#include "tests/common/testing/test_with_folder.h"
#include "tests/system/graph.h"
#include "tests/system/run_program.h"

namespace sprout {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::IsSubsetOf;

const std::string kRecord = SPROUT_SOURCE_DIR "/scripts/record";

/// Whether a program runs that was given this argument.
bool SomebodyHas(const std::string& argument) {
  std::error_code gone;
  for (const auto& process : std::filesystem::directory_iterator("/proc")) {
    std::ifstream file(process.path() / "cmdline", std::ios::binary);
    const std::string line{std::istreambuf_iterator<char>(file), {}};
    if (line.find(argument) != std::string::npos) return true;
  }
  return false;
}

/// The log that is being recorded in a folder; empty while there is none.
std::filesystem::path GrowingLog(const std::filesystem::path& folder) {
  std::error_code missing;
  for (const auto& entry : std::filesystem::directory_iterator(folder, missing)) {
    if (entry.path().extension() == ".lcm" && entry.file_size() > 0) return entry.path();
  }
  return {};
}

std::vector<std::string> ChannelNames(const ChannelBytes& channels) {
  std::vector<std::string> names;
  for (const auto& [name, messages] : channels) names.push_back(name);
  return names;
}

class RecordSystem : public TestWithFolder {
 protected:
  // What scripts/record writes that ends with this exit code.
  std::string Record(std::vector<std::string> flags, int exit_code = 0) const {
    flags.insert(flags.begin(), {kRecord, "--dir", folder_ / "logs"});
    return OutputOf(flags, exit_code);
  }
};

TEST_F(RecordSystem, WritesTheRawChannelsWithoutAGap) {
  Graph graph;
  graph.Start("refine");
  graph.Start("capture", {"--source", "synthetic:160x120", "--rate", "20"});
  const std::string said = Record({"--seconds", "2", "run"});
  const ChannelBytes channels = ReadChannels(folder_ / "logs/run.lcm");
  EXPECT_THAT(ChannelNames(channels),
              testing::UnorderedElementsAre("SPROUT_LEFT", "SPROUT_PROCESS", "SPROUT_RIG",
                                            "SPROUT_RIGHT", "SPROUT_STATUS", "SPROUT_TOF"))
      << said;
  const auto& left = channels.at("SPROUT_LEFT");
  EXPECT_GE(left.size(), 20U);
  int64_t expected = DecodePart(Part::kLeft, left.front())->id.seq;
  for (const auto& bytes : left) {
    EXPECT_EQ(DecodePart(Part::kLeft, bytes)->id.seq, expected++) << said;
  }
}

TEST_F(RecordSystem, HasWhatEveryProcessIsAlthoughItBeginsLater) {
  Graph graph;
  graph.Start("refine");
  graph.Start("capture", {"--source", "synthetic:160x120", "--rate", "20"});
  ASSERT_TRUE(graph.WaitUntil([&](Graph& g) { return g.statuses["refine"].frames_out > 10; }));
  const std::string said = Record({"--seconds", "4", "run"});
  std::map<std::string, ProcessInfo> processes;
  const ChannelBytes channels = ReadChannels(folder_ / "logs/run.lcm");
  for (const auto& bytes : channels.at("SPROUT_PROCESS")) {
    const auto info = DecodeProcessInfo(bytes);
    ASSERT_TRUE(info) << info.error().text;
    processes[info->stage] = *info;
  }
  ASSERT_EQ(processes.size(), 2U) << said;
  EXPECT_THAT(processes["capture"].config_text, HasSubstr("source: \"synthetic:160x120\""));
  EXPECT_EQ(processes["refine"].config_digest, graph.statuses["refine"].config_digest);
  EXPECT_EQ(processes["refine"].version, graph.statuses["refine"].version);
}

TEST_F(RecordSystem, RecordsInFewerBytesWhenAsked) {
  Graph graph;
  graph.Start("refine");
  graph.Start("capture", {"--source", "synthetic:160x120", "--rate", "20"});
  EXPECT_THAT(Record({"--seconds", "2", "--compress", "run"}), HasSubstr("MB of messages became"));
  const ChannelBytes channels = ReadChannels(folder_ / "logs/run.lcm");
  EXPECT_GE(channels.at("SPROUT_LEFT").size(), 20U);
  for (const auto& [channel, messages] : channels) {
    for (const auto& bytes : messages) {
      EXPECT_EQ(IsPacked(bytes),
                channel == "SPROUT_LEFT" || channel == "SPROUT_RIGHT" || channel == "SPROUT_TOF");
      if (!IsPacked(bytes)) continue;
      const Result<std::vector<uint8_t>> message = Unpack(bytes);
      ASSERT_TRUE(message) << message.error().text;
      EXPECT_LT(bytes.size(), message->size()) << channel;
    }
  }
}

// Live, from a log, and as JPEG.
TEST_F(RecordSystem, ReplaysACompressedLogToTheSameBytes) {
  const std::string small = folder_ / "small.lcm";
  const std::string jpeg = folder_ / "jpeg.lcm";
  OutputOf({"sprout-log", "compress", kSampleLog, small});
  OutputOf({"sprout-log", "compress", "--jpeg", "90", kSampleLog, jpeg});
  EXPECT_LT(std::filesystem::file_size(small), std::filesystem::file_size(kSampleLog));
  const auto replay = [&](const std::string& log, const char* name) {
    Replay("sprout-pipeline", "default", {log}, folder_ / name);
    return ReadChannels(folder_ / name);
  };
  const ChannelBytes expected = replay(kSampleLog, "answers.lcm");
  EXPECT_TRUE(replay(small, "answers_small.lcm") == expected);
  EXPECT_EQ(replay(jpeg, "answers_jpeg.lcm").at("SPROUT_DISPARITY").size(),
            expected.at("SPROUT_DISPARITY").size());
}

TEST_F(RecordSystem, EndsWithASignalAndTakesAllChannelsOnDemand) {
  Graph graph("A_");
  graph.Start("refine");
  Process record(
      {kRecord, "--dir", folder_ / "logs", "--all", "--channel-prefix", "A_", "run.lcm"});
  // The log appears with the first status.
  ASSERT_TRUE(graph.WaitUntil([&](Graph&) { return !GrowingLog(folder_ / "logs").empty(); }));
  record.Signal(SIGINT);
  EXPECT_TRUE(record.Wait()) << record.Output();
  EXPECT_THAT(
      ChannelNames(ReadChannels(folder_ / "logs/run.lcm")),
      AllOf(Contains("A_SPROUT_STATUS"), IsSubsetOf({"A_SPROUT_PROCESS", "A_SPROUT_STATUS"})));
}

TEST_F(RecordSystem, SaysSoWhenOneImageOfThePairIsMissing) {
  Graph graph;
  graph.Start("refine");
  Process record({kRecord, "--dir", folder_ / "logs", "--seconds", "3", "run"});
  ASSERT_TRUE(graph.WaitUntil([&](Graph&) {
    graph.PublishPart({.utime = 1, .seq = 1, .rig_id = "a"}, Part::kRight,
                      cv::Mat(cv::Mat1b(9, 9)));
    return !GrowingLog(folder_ / "logs").empty();
  }));
  EXPECT_EQ(record.Wait(), 1);
  EXPECT_THAT(record.Output(), HasSubstr("SPROUT_LEFT is missing: every one was lost"));
}

// A terminal that is closed, and a script that is killed: neither may leave a recorder behind,
// which would write for ever.
TEST_F(RecordSystem, LeavesNoRecorderBehind) {
  for (const int signal : {SIGHUP, SIGKILL}) {
    const TemporaryDirectory folder;
    Graph graph;
    graph.Start("refine");
    Process record({kRecord, "--dir", folder / "logs", "--all", "run"});
    const std::string logs = folder / "logs";
    ASSERT_TRUE(graph.WaitUntil([&](Graph&) { return !GrowingLog(logs).empty(); }));
    ASSERT_TRUE(SomebodyHas(logs));
    record.Signal(signal);
    // 1: there was no capture, so it has no frame.
    EXPECT_EQ(record.Wait(), signal == SIGHUP ? 1 : 128 + SIGKILL) << record.Output();
    EXPECT_TRUE(graph.WaitUntil([&](Graph&) { return !SomebodyHas(logs); }));
    EXPECT_THAT(ChannelNames(ReadChannels(GrowingLog(logs).string())),
                AllOf(Contains("SPROUT_STATUS"), IsSubsetOf({"SPROUT_PROCESS", "SPROUT_STATUS"})));
  }
}

TEST_F(RecordSystem, LeavesNoEmptyLogBehindWhenTheUrlIsBad) {
  EXPECT_THAT(Record({"--lcm-url", "nonsense://", "run"}, 2), HasSubstr("--lcm-url"));
  EXPECT_TRUE(GrowingLog(folder_ / "logs").empty());
}

TEST(DemoScript, RefusesASecondOneAtATime) {
  const std::string tree = SPROUT_SOURCE_DIR;
  std::filesystem::create_directory(tree + "/out");
  const std::string lock = tree + "/out/demo.lock";
  const int descriptor = open(lock.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0666);
  ASSERT_GE(descriptor, 0);
  flock(descriptor, LOCK_EX | LOCK_NB);  // if it fails, a demo holds the lock, which is as good
  EXPECT_THAT(OutputOf({tree + "/scripts/demo", "--synthetic"}, 1),
              HasSubstr("another demo writes to"));
  close(descriptor);
}

TEST_F(RecordSystem, CountsNoGapsWhereDepthGivesEveryThirdFrame) {
  Graph graph;
  graph.Start("record", {"--dir", folder_ / "logs", "--channels", "SPROUT_DEPTH", "--config",
                         "depth { every: 3 }"});
  const DepthImage depth{
      .counts = cv::Mat1w(9, 9, uint16_t{0}), .metres_per_count = 0.001, .focal_px = 9};
  for (const int64_t seq : {0, 3, 6, 12}) {
    graph.PublishPart({.utime = 1, .seq = seq, .rig_id = "a"}, Part::kDepth, depth);
  }
  EXPECT_TRUE(graph.WaitUntil([](Graph& g) { return g.statuses["record"].frames_in == 4; }));
  graph.Look([](Graph& g) {
    EXPECT_EQ(g.statuses["record"].sequence_gaps, 1);  // frame 9
  });
}

TEST_F(RecordSystem, SaysSoWhenNoFrameCame) {
  Graph graph;
  graph.Start("refine");
  EXPECT_THAT(Record({"--seconds", "4", "run"}, 1),
              HasSubstr("no frame was recorded; is capture running"));
}

TEST(RecordScript, RefusesAFlagWithoutItsValue) {
  for (const std::string flag : {"--dir", "--channel-prefix", "--seconds"}) {
    EXPECT_THAT(OutputOf({kRecord, "run", flag}, 2),
                testing::StartsWith("record: " + flag + " needs a "));
  }
}

TEST(RecordScript, RefusesANameThatNoFileCanHave) {
  for (const std::string& name : {std::string(252, 'a'), std::string(), std::string("a/b")}) {
    EXPECT_THAT(OutputOf({kRecord, name}, 2), testing::StartsWith("record: ")) << name;
  }
}

TEST(Scripts, TakePathsFromWhereTheyAreCalled) {
  const auto run = [](const std::string& command, int exit_code) {
    OutputOf({"sh", "-c", "cd " SPROUT_SOURCE_DIR "/logs && exec ../scripts/" + command}, exit_code,
             std::chrono::seconds(60));
  };
  run("run_graph --source=log:sample.lcm --config sample.textproto", 0);
  run("record --config sample.textproto --channels A --seconds 1", 1);  // no A
}

TEST_F(RecordSystem, SaysSoWhenThereIsNothingToRecord) {
  EXPECT_THAT(
      OutputOf({kRecord, "--dir=" + std::string(folder_ / "logs"), "--seconds", "1", "run"}, 1),
      HasSubstr("nothing came; is the graph running"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "logs/run.lcm"));
}

}  // namespace
}  // namespace sprout
