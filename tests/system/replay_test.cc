#include <gmock/gmock.h>

#include <chrono>
#include <cmath>
#include <csignal>
#include <fstream>
#include <string>
#include <thread>

#include "common/bus/channels.h"
#include "common/logfile/log_writer.h"
#include "common/messages/codec.h"
#include "common/scenes/dataset.h"
#include "tests/common/picture/temporary_directory.h"
#include "tests/system/graph.h"
#include "tests/system/run_program.h"

namespace sprout {
namespace {

using testing::HasSubstr;

bool HasBytes(const std::filesystem::path& path) {
  std::error_code ignored;
  const auto size = std::filesystem::file_size(path, ignored);
  return !ignored && size > 0;
}

// Every message of one log by its frame's number.
std::map<int64_t, std::vector<uint8_t>> BySeq(const ChannelBytes& channels, Part part) {
  std::map<int64_t, std::vector<uint8_t>> by_seq;
  const auto found = channels.find(std::string(ChannelOf(part)));
  if (found == channels.end()) return by_seq;
  for (const auto& bytes : found->second) by_seq[DecodePart(part, bytes)->id.seq] = bytes;
  return by_seq;
}

void CopyRawChannels(const std::filesystem::path& from, const std::filesystem::path& to) {
  LogReader reader(from);
  LogWriter writer(to);
  LogEvent event;
  while (reader.Next(event)) {
    for (const Part part : {Part::kLeft, Part::kRight, Part::kTof, Part::kRig}) {
      if (event.channel == ChannelOf(part)) writer.Write(event.utime, event.channel, event.data);
    }
  }
  writer.Close();
}

// Records a live run without lockstep, so that stages may skip frames, until the last answer that
// they gave is in the log.
void RecordLiveRun(const std::filesystem::path& log, const std::string& source, int frames) {
  Graph graph;
  graph.StartChain();
  Process logger({"lcm-logger", "-m", "1000", std::string("--lcm-url=") + kDefaultLcmUrl, log});
  // A status in the log shows that the logger listens.
  ASSERT_TRUE(Eventually([&] { return HasBytes(log); })) << logger.Output();
  Process& capture =
      graph.StartOnly("capture", {"--source", source, "--frames", std::to_string(frames), "--rate",
                                  "30", "--wait-for", "refine,prior,grow"});
  EXPECT_EQ(capture.Wait(), 0) << capture.Output();
  int64_t answered = 0;
  EXPECT_TRUE(graph.WaitUntil([&](Graph& g) {
    answered = g.statuses["grow"].frames_out;
    return g.parts.contains({Part::kDisparity, frames - 1}) &&
           g.statuses["grow"].newest_frame.seq == frames - 1;
  }));
  EXPECT_TRUE(Eventually(
      [&] { return std::ssize(BySeq(ReadChannels(log), Part::kDisparity)) == answered; }));
  logger.Signal(SIGINT);
  EXPECT_TRUE(logger.Wait()) << logger.Output();
}

class ReplayOf : public testing::TestWithParam<const char*> {};

TEST_P(ReplayOf, GivesTheBytesThatTheLiveRunPublished) {
  constexpr int kFrames = 30;
  const TemporaryDirectory folder;
  const auto live = folder / "live.lcm";
  const auto raw = folder / "raw.lcm";
  RecordLiveRun(live, GetParam(), kFrames);
  CopyRawChannels(live, raw);
  const auto seeds = folder / "seeds.lcm";
  const auto prior = folder / "prior.lcm";
  const auto disparity = folder / "disparity.lcm";
  Replay("sprout-refine", "default", {raw}, seeds);
  Replay("sprout-prior", "default", {raw, seeds}, prior);
  Replay("sprout-grow", "default", {raw, seeds, prior}, disparity);

  const ChannelBytes recorded = ReadChannels(live);
  const struct {
    Part part;
    std::filesystem::path log;
  } table[] = {{Part::kSeeds, seeds},
               {Part::kLeftSeeds, seeds},
               {Part::kPrior, prior},
               {Part::kDisparity, disparity}};
  for (const auto& [part, log] : table) {
    const auto expected = BySeq(recorded, part);
    const auto replayed = BySeq(ReadChannels(log), part);
    EXPECT_THAT(replayed, testing::SizeIs(kFrames)) << ChannelOf(part);
    EXPECT_GT(expected.size(), 0U) << ChannelOf(part);
    for (const auto& [seq, bytes] : expected) {
      ASSERT_TRUE(replayed.contains(seq)) << ChannelOf(part) << " of frame " << seq;
      EXPECT_EQ(replayed.at(seq), bytes) << ChannelOf(part) << " of frame " << seq;
    }
  }
  for (const auto& [seq, bytes] : BySeq(ReadChannels(disparity), Part::kDisparity)) {
    const auto message = DecodePart(Part::kDisparity, bytes);
    const auto& map = std::get<DisparityImage>(message->value);
    EXPECT_GT(map.CountValid(), 0.9 * map.size().area()) << "frame " << seq;
  }
}

INSTANTIATE_TEST_SUITE_P(ReplaySystem, ReplayOf,
                         testing::Values("synthetic:320x240", "synthetic:320x240?tof=none"),
                         [](const auto& source) {
                           return source.index == 0 ? "WithTof" : "WithoutTof";
                         });

TEST(ReplaySystem, AReplayOfARecordingWithAllChannelsGivesTheSame) {
  const TemporaryDirectory folder;
  const auto once = folder / "once.lcm";
  const auto twice = folder / "twice.lcm";
  Replay("sprout-refine", "default", {kSampleLog}, once);
  Replay("sprout-refine", "default", {kSampleLog, once}, twice);
  EXPECT_EQ(ReadChannels(once), ReadChannels(twice));
}

// A log on which grow is busy for a while.
void WriteLongLog(const std::filesystem::path& path, int frames) {
  const auto source = scenes::OpenDataset("synthetic:320x240");
  const scenes::DatasetFrame captured = source->Get(0);
  SeedSet seeds;  // every eighth pixel of every eighth row
  for (int v = 4; v < captured.left.rows; v += 8) {
    for (int u = 4; u < captured.left.cols; u += 8) {
      const auto at_u = static_cast<float>(u);
      const float right_u = at_u - std::round(captured.truth.left(v, u));
      if (right_u >= 0) seeds.seeds.push_back({at_u, static_cast<float>(v), right_u});
    }
  }
  LogWriter writer(path);
  for (int64_t seq = 0; seq < frames; ++seq) {
    const FrameId id{.utime = 1000 * seq, .seq = seq, .rig_id = RigId(source->rig())};
    const auto write = [&](Part part, const PartValue& value) {
      writer.Write(id.utime, ChannelOf(part), EncodePart(id, part, value));
    };
    write(Part::kLeft, captured.left);
    write(Part::kRight, captured.right);
    write(Part::kSeeds, seeds);
  }
  writer.Close();
}

TEST(ReplaySystem, ASignalLeavesAReadableLogOfWhatWasDone) {
  constexpr int kFrames = 200;
  for (const int signal : {SIGINT, SIGTERM}) {
    const TemporaryDirectory folder;
    WriteLongLog(folder / "in.lcm", kFrames);
    std::ofstream(folder / "slow.textproto")
        << "grow { similarity: MNCC fill: NONE publish_confidence: false }";
    const auto out = folder / "out.lcm";
    Process grow({ProgramPath("sprout-grow"), "--config", folder / "slow.textproto", "--replay",
                  folder / "in.lcm", "--record", out});
    // Its output has no name yet, so nothing else tells that it computes.
    ASSERT_TRUE(
        Eventually([&] { return grow.Output().find("configuration") != std::string::npos; }));
    std::this_thread::sleep_for(std::chrono::seconds(1));
    EXPECT_FALSE(std::filesystem::exists(out));
    grow.Signal(signal);
    EXPECT_EQ(grow.Wait(), 1) << grow.Output();
    EXPECT_THAT(grow.Output(), HasSubstr("grow: stopped after "));
    EXPECT_FALSE(std::filesystem::exists(out.string() + ".part"));

    LogReader reader(out);
    LogEvent event;
    ASSERT_TRUE(reader.Next(event));
    EXPECT_EQ(event.channel, kProcessChannel);
    int64_t seq = 0;
    for (; reader.Next(event); ++seq) {
      EXPECT_EQ(DecodePart(Part::kDisparity, event.data)->id.seq, seq);
    }
    EXPECT_GT(seq, 0);
    EXPECT_LT(seq, kFrames);
    EXPECT_TRUE(reader.damage().empty());
  }
}

TEST(ReplaySystem, RunsWithoutANetwork) {
  const TemporaryDirectory folder;
  EXPECT_THAT(OutputOf({"unshare", "--net", ProgramPath("sprout-refine"), "--replay", kSampleLog,
                        "--record", folder / "out.lcm"}),
              testing::Not(HasSubstr(" W ")))
      << "no word about buffers";
}

}  // namespace
}  // namespace sprout
