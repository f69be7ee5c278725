// sprout-pipeline in the place of refine, prior and grow.
#include <gmock/gmock.h>

#include <algorithm>
#include <csignal>
#include <fstream>

#include "common/logfile/log_writer.h"
#include "common/messages/codec.h"
#include "common/scenes/dataset.h"
#include "tests/common/picture/temporary_directory.h"
#include "tests/system/graph.h"
#include "tests/system/in_process.h"
#include "tests/system/run_program.h"

namespace sprout {
namespace {

constexpr char kSource[] = "synthetic:320x240";

ChannelBytes AnswersOf(const std::string& program, const std::string& config,
                       const std::vector<std::filesystem::path>& logs,
                       const std::filesystem::path& record) {
  Replay(program, config, logs, record);
  ChannelBytes channels = ReadChannels(record);
  EXPECT_EQ(channels.erase(std::string(kProcessChannel)), 1U);
  return channels;
}

TEST(OneProcessSystem, ReplayGivesTheBytesOfTheThreeStages) {
  const TemporaryDirectory folder;
  const std::string without_prior = folder / "without_prior.textproto";
  std::ofstream(without_prior) << "prior { left_seeds: false } grow { similarity: EXPSSD fill: "
                                  "NONE publish_unfilled: true }";
  for (const std::string& config : {std::string("default"), std::string("paper"), without_prior}) {
    const auto seeds = folder / "seeds.lcm";
    const auto prior = folder / "prior.lcm";
    ChannelBytes three = AnswersOf("sprout-refine", config, {kSampleLog}, seeds);
    three.merge(AnswersOf("sprout-prior", config, {kSampleLog, seeds}, prior));
    three.merge(AnswersOf("sprout-grow", config, {kSampleLog, seeds, prior}, folder / "grow.lcm"));
    const ChannelBytes one =
        AnswersOf("sprout-pipeline", config, {kSampleLog}, folder / "pipeline.lcm");
    ASSERT_TRUE(one.contains("SPROUT_DISPARITY")) << config;
    EXPECT_TRUE(one.contains("SPROUT_PRIOR")) << config;
    EXPECT_EQ(one.contains("SPROUT_UNFILLED"), config == without_prior);
    EXPECT_TRUE(one == three) << config;
  }
}

// Live and replayed, and as sprout-temporal does it behind the chain.
TEST(OneProcessSystem, FusesFramesToTheBytesOfSproutTemporal) {
  constexpr int kFrames = 5;
  constexpr Part kFusedParts[] = {Part::kFused, Part::kFusedConfidence, Part::kMotion};
  const std::string config = "temporal { in_pipeline: true }";
  const auto source = scenes::OpenDataset(kSource);
  const TemporaryDirectory folder;
  LogWriter writer(folder / "in.lcm");
  Graph graph;
  graph.Start("pipeline", {"--config", config});
  std::map<Part, std::vector<std::vector<uint8_t>>> live;
  for (int64_t seq = 0; seq < kFrames; ++seq) {
    const scenes::DatasetFrame frame = source->Get(seq);
    const FrameId id{
        .utime = 1'000'000 + 100'000 * seq, .seq = seq, .rig_id = RigId(source->rig())};
    const std::pair<Part, PartValue> parts[] = {{Part::kRig, source->rig()},
                                                {Part::kLeft, frame.left},
                                                {Part::kRight, frame.right},
                                                {Part::kTof, frame.tof}};
    for (const auto& [part, value] : parts) {
      const auto bytes = EncodePart(id, part, value);
      graph.Publish(ChannelOf(part), bytes);
      writer.Write(id.utime, ChannelOf(part), bytes);
    }
    ASSERT_TRUE(graph.WaitUntil([&](Graph& g) {
      for (const Part part : kFusedParts) {
        if (!g.parts.contains({part, seq})) return false;
      }
      for (const Part part : kFusedParts) {
        live[part].push_back(EncodePart(id, part, g.parts.at({part, seq})));
      }
      return true;
    })) << seq;
  }
  writer.Close();
  EXPECT_TRUE(graph.WaitUntil([&](Graph& g) {
    const StageStatus& step = g.statuses["temporal"];
    return step.frames_out == kFrames && step.frames_degenerate == 0 &&
           step.pid == g.statuses["pipeline"].pid && step.tof_coverage == kUnknownCoverage;
  }));
  ChannelBytes one = AnswersOf("sprout-pipeline", config, {folder / "in.lcm"}, folder / "one.lcm");
  for (const Part part : kFusedParts) {
    EXPECT_TRUE(one.at(std::string(ChannelOf(part))) == live.at(part)) << ChannelOf(part);
  }
  ChannelBytes apart =
      AnswersOf("sprout-pipeline", "default", {folder / "in.lcm"}, folder / "c.lcm");
  apart.merge(AnswersOf("sprout-temporal", "default", {folder / "in.lcm", folder / "c.lcm"},
                        folder / "temporal.lcm"));
  EXPECT_TRUE(one == apart);
  EXPECT_FALSE(one.at("SPROUT_FUSED").back() == one.at("SPROUT_DISPARITY").back());
}

// Nobody sends SPROUT_ODOMETRY.
TEST(OneProcessSystem, ComputesMapsWithoutTheMotionThatOnlyTheMemoryNeeds) {
  const TemporaryDirectory folder;
  const std::string config = "temporal { in_pipeline: true motion: CHANNEL }";
  const ChannelBytes given =
      AnswersOf("sprout-pipeline", config, {kSampleLog}, folder / "without.lcm");
  const ChannelBytes plain =
      AnswersOf("sprout-pipeline", "default", {kSampleLog}, folder / "plain.lcm");
  for (const auto& [channel, messages] : plain) {
    EXPECT_TRUE(given.at(channel) == messages) << channel;
  }
  EXPECT_EQ(given.at("SPROUT_MOTION").size(), plain.at("SPROUT_DISPARITY").size());
}

TEST(OneProcessSystem, AnswersEveryFrameAndReportsItsStepsUnderTheNamesOfTheProcesses) {
  constexpr int kFrames = 5;
  Graph graph;
  Process& pipeline = graph.Start("pipeline", {"--config", "default"});
  Process& capture = graph.StartOnly(
      "capture", {"--source", kSource, "--frames", std::to_string(kFrames), "--lockstep", "1",
                  "--rate", "0", "--wait-for", "refine,prior,grow"});
  EXPECT_EQ(capture.Wait(), 0) << capture.Output();
  ASSERT_TRUE(graph.WaitUntil([](Graph& g) {
    for (const char* stage : {"refine", "prior", "grow", "pipeline"}) {
      if (g.statuses[stage].frames_out < kFrames) return false;
    }
    return true;
  }));
  graph.Look([](Graph& g) {
    const StageStatus& whole = g.statuses["pipeline"];
    for (const char* stage : kChain) {
      const StageStatus& step = g.statuses[stage];
      EXPECT_EQ(step.frames_in, whole.frames_in) << stage;
      EXPECT_EQ(step.newest_frame.seq, kFrames - 1) << stage;
      EXPECT_EQ(step.pid, whole.pid) << stage;
      EXPECT_GT(step.latency.p50_ms, 0) << stage;
      EXPECT_LT(step.latency.p50_ms, whole.latency.p50_ms) << stage;
      EXPECT_GT(step.tof_coverage, 0) << stage;
      EXPECT_EQ(step.tof_coverage, whole.tof_coverage) << stage;
      EXPECT_EQ(step.last_error, "") << stage;
    }
    EXPECT_EQ(whole.frames_skipped, 0);
    EXPECT_EQ(whole.bad_messages, 0);
    EXPECT_EQ(whole.frames_failed, 0);
    EXPECT_EQ(whole.frames_degenerate, 0);
    for (int64_t seq = 0; seq < kFrames; ++seq) {
      for (const Part part :
           {Part::kSeeds, Part::kLeftSeeds, Part::kPrior, Part::kConfidence, Part::kSigma}) {
        EXPECT_GE((g.part_counts[{part, seq}]), 1) << ChannelOf(part) << " of frame " << seq;
      }
      const auto& map = std::get<DisparityImage>(g.parts.at({Part::kDisparity, seq}));
      EXPECT_EQ(cv::countNonZero(map.counts() != ComputeInProcess(kSource, seq).counts()), 0)
          << seq;
    }
  });
  pipeline.Signal(SIGTERM);
  EXPECT_EQ(pipeline.Wait(), 0) << pipeline.Output();
  EXPECT_TRUE(graph.WaitUntil([](Graph& g) {
    for (const char* stage : {"refine", "prior", "grow", "pipeline"}) {
      if (g.statuses[stage].state != StageStatus::State::kStopped) return false;
    }
    return true;
  }));
}

TEST(OneProcessSystem, AStageBesideItWarnsThatThereAreTwo) {
  Graph graph;
  graph.Start("pipeline");
  graph.StartOnly("refine");
  EXPECT_TRUE(graph.WaitUntil([](Graph& g) {
    return g.statuses["refine"].last_error.starts_with("another sprout-refine works on these");
  }));
}

TEST(OneProcessSystem, RefusesFlagsOfFilesThatCannotBeUsedInOneLine) {
  const std::vector<std::string> good = {"files", "a.png", "b.png", "--out", "out"};
  const struct {
    std::vector<std::string> flags;
    std::string text;
  } table[] = {
      {{}, "no calibration"},
      {{"--focal-px", "100"}, "--baseline-m"},
      {{"--focal-px", "nan", "--baseline-m", "1"}, "--focal-px"},
      {{"--focal-px", "100", "--baseline-m", "0"}, "--baseline-m"},
      {{"--focal-px", "100", "--baseline-m", "1", "--rig", "rig.textproto"}, "--rig"},
      {{"--focal-px", "100", "--baseline-m", "1"}, "LEFT a.png: not there"},
      {{"--rig", "rig.textproto", "--lcm-url", "udpm://239.255.76.67:7667?ttl=0"}, "--lcm-url"},
      {{"--rig", "rig.textproto", "--config", "nothing"}, "nothing"},
      {{"c.png", "--rig", "rig.textproto"}, "c.png"},
      {{"--rig", "rig.textproto", "--tof-unit", "cm"}, "--tof-unit requires --tof "},
      {{"--focal-px", "100", "--baseline-m", "1", "--tof-rig", "tof"}, "--tof-rig requires --tof "},
  };
  for (const auto& [flags, text] : table) {
    std::vector<std::string> command = {"sprout-pipeline", "--log-level", "error"};
    command.insert(command.end(), good.begin(), good.end());
    command.insert(command.end(), flags.begin(), flags.end());
    const std::string said = OutputOf(command, 2);
    EXPECT_THAT(said, testing::HasSubstr(text));
    EXPECT_EQ(std::ranges::count(said, '\n'), 1) << said;
  }
}

}  // namespace
}  // namespace sprout
