#include "tests/system/graph.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>

#include "common/scenes/dataset.h"
#include "tests/system/in_process.h"

namespace sprout {
namespace {

constexpr char kSource[] = "synthetic:320x240";
constexpr char kWithoutTof[] = "synthetic:320x240?tof=none";

bool SamePixels(const DisparityImage& a, const DisparityImage& b) {
  return a.size() == b.size() && cv::countNonZero(a.counts() != b.counts()) == 0;
}

TEST(GraphSystem, DeliversEveryFrameWithTheBytesOfTheStagesAlone) {
  Graph graph;
  graph.StartChain();
  graph.Capture({"--source", kSource, "--frames", "5", "--rate", "0"});
  ASSERT_TRUE(graph.WaitUntil([](Graph& g) {
    return g.parts.contains({Part::kDisparity, 4}) && g.statuses["grow"].frames_out == 5;
  }));
  for (int64_t seq = 0; seq < 5; ++seq) {
    EXPECT_TRUE(graph.WaitUntil(
        [&](Graph& g) {
          return SamePixels(std::get<DisparityImage>(g.parts.at({Part::kDisparity, seq})),
                            ComputeInProcess(kSource, seq));
        },
        std::chrono::seconds(1)))
        << "frame " << seq;
  }
  graph.Look([](Graph& g) {
    for (const auto& [stage, status] : g.statuses) {
      EXPECT_EQ(status.bad_messages, 0) << stage;
      EXPECT_EQ(status.sequence_gaps, 0) << stage;
      EXPECT_EQ(status.frames_skipped, 0) << stage;
      EXPECT_EQ(status.frames_failed, 0) << stage;
      EXPECT_EQ(status.last_error, "") << stage;
    }
  });
}

TEST(GraphSystem, WithoutATofCameraStereoGivesTheMapAndTheStatusesSayNoCoverage) {
  constexpr int kFrames = 3;
  Graph graph;
  graph.StartChain();
  graph.Capture({"--source", kWithoutTof, "--frames", std::to_string(kFrames), "--rate", "0"});
  ASSERT_TRUE(graph.WaitUntil([](Graph& g) {
    return g.parts.contains({Part::kDisparity, kFrames - 1}) &&
           g.statuses["grow"].frames_out == kFrames;
  }));
  const auto source = scenes::OpenDataset(kWithoutTof);
  graph.Look([&](Graph& g) {
    for (int64_t seq = 0; seq < kFrames; ++seq) {
      const auto& map = std::get<DisparityImage>(g.parts.at({Part::kDisparity, seq}));
      EXPECT_GT(map.CountValid(), 0.95 * map.size().area()) << "frame " << seq;
      EXPECT_GT(CorrectPercent(map, source->Get(seq).truth), 80) << "frame " << seq;
      EXPECT_TRUE(SamePixels(map, ComputeInProcess(kWithoutTof, seq))) << "frame " << seq;
    }
    for (const char* stage : kChain) {
      const StageStatus& status = g.statuses[stage];
      EXPECT_EQ(status.tof_coverage, 0) << stage;
      EXPECT_EQ(status.frames_degenerate, 0) << stage << ": " << status.last_error;
    }
  });
}

TEST(GraphSystem, TwoGraphsRunSideBySideUnderTwoPrefixes) {
  Graph one("ONE_");
  Graph two("TWO_");
  one.StartChain();
  one.Capture({"--source", kSource, "--frames", "2"});
  EXPECT_TRUE(one.WaitUntil([](Graph& g) { return g.parts.contains({Part::kDisparity, 1}); }));
  two.Look([](Graph& g) {
    EXPECT_TRUE(g.parts.empty());
    EXPECT_TRUE(g.statuses.empty());
  });
}

TEST(GraphSystem, SendsAFrameAgainAndTheStagesTakeItTwice) {
  Graph graph;
  for (const char* stage : {"refine", "prior"}) graph.Start(stage, {"--config", "default"});
  // Nobody answers: grow comes late.
  Process& capture =
      graph.StartOnly("capture", {"--source", kSource, "--frames", "2", "--lockstep", "1",
                                  "--lockstep-timeout", "1", "--wait-for", "refine,prior"});
  ASSERT_TRUE(graph.WaitUntil([](Graph& g) { return g.part_counts[{Part::kPrior, 0}] >= 2; }));
  graph.Start("grow", {"--config", "default"});
  EXPECT_EQ(capture.Wait(), 0) << capture.Output();
  ASSERT_TRUE(graph.WaitUntil([](Graph& g) {
    return g.statuses["capture"].state == StageStatus::State::kStopped &&
           g.statuses["refine"].newest_frame.seq == 1;
  }));
  graph.Look([](Graph& g) {
    EXPECT_GE(g.statuses["capture"].frames_resent, 1);
    EXPECT_EQ(g.statuses["refine"].frames_incomplete, 0);
    EXPECT_EQ(g.statuses["refine"].sequence_gaps, 0);
    EXPECT_TRUE(SamePixels(std::get<DisparityImage>(g.parts.at({Part::kDisparity, 0})),
                           ComputeInProcess(kSource, 0)));
  });
}

TEST(GraphSystem, SendsFramesAgainAsSoonAsLaterOnesAreAnswered) {
  Graph graph;
  graph.StartChain();
  Process& capture = graph.StartOnly(
      "capture", {"--source", kSource, "--frames", "24", "--rate", "20", "--lockstep", "8",
                  "--lockstep-timeout", "3600", "--wait-for", "refine,prior,grow"});
  ASSERT_TRUE(graph.WaitUntil([](Graph& g) { return g.parts.contains({Part::kDisparity, 3}); }));
  // Refine finds several frames waiting, and skips all but the newest.
  graph.process("refine").Signal(SIGSTOP);
  ASSERT_TRUE(graph.WaitUntil([](Graph& g) { return g.parts.contains({Part::kLeft, 10}); }));
  graph.process("refine").Signal(SIGCONT);
  EXPECT_EQ(capture.Wait(std::chrono::seconds(30)), 0) << capture.Output();
  ASSERT_TRUE(graph.WaitUntil(
      [](Graph& g) { return g.statuses["capture"].state == StageStatus::State::kStopped; }));
  graph.Look([](Graph& g) {
    EXPECT_GT(g.statuses["capture"].frames_resent, 0);
    for (int64_t seq = 0; seq < 24; ++seq) EXPECT_TRUE(g.parts.contains({Part::kDisparity, seq}));
  });
}

TEST(GraphSystem, GoesOnWhenAStageIsKilledAndStartedAgain) {
  Graph graph;
  graph.StartChain();
  Process& capture = graph.StartOnly(
      "capture", {"--source", kSource, "--frames", "40", "--lockstep", "1", "--lockstep-timeout",
                  "1", "--rate", "20", "--wait-for", "refine,prior,grow"});
  ASSERT_TRUE(graph.WaitUntil([](Graph& g) { return g.parts.contains({Part::kDisparity, 3}); }));
  graph.process("prior").Signal(SIGKILL);
  EXPECT_EQ(graph.process("prior").Wait(), 128 + SIGKILL);
  graph.Start("prior", {"--config", "default"});
  EXPECT_EQ(capture.Wait(std::chrono::seconds(60)), 0) << capture.Output();
  for (int64_t seq = 0; seq < 40; ++seq) {
    EXPECT_TRUE(graph.WaitUntil(
        [&](Graph& g) {
          return g.parts.contains({Part::kDisparity, seq});
        },
        std::chrono::seconds(2)))
        << "frame " << seq;
  }
}

TEST(GraphSystem, SkipsAndCountsFramesThatComeTooFast) {
  Graph graph;
  graph.StartChain();
  Process& capture = graph.StartOnly("capture", {"--source", kSource, "--frames", "40", "--rate",
                                                 "20", "--wait-for", "refine,prior,grow"});
  ASSERT_TRUE(graph.WaitUntil([](Graph& g) { return g.parts.contains({Part::kDisparity, 3}); }));
  // Grow stands still, and finds the other frames waiting all at once. It answers the one that it
  // was at work on, and the newest.
  graph.process("grow").Signal(SIGSTOP);
  EXPECT_EQ(capture.Wait(std::chrono::seconds(60)), 0) << capture.Output();
  int64_t answered = 0;
  const auto count_answers = [&](Graph& g) {
    answered = std::ranges::count_if(
        g.parts, [](const auto& entry) { return entry.first.first == Part::kDisparity; });
    return g.parts.contains({Part::kPrior, 39});
  };
  EXPECT_TRUE(graph.WaitUntil(count_answers));
  const int64_t answered_before = answered;
  graph.process("grow").Signal(SIGCONT);
  EXPECT_TRUE(graph.WaitUntil([](Graph& g) {
    const StageStatus& grow = g.statuses["grow"];
    return grow.newest_frame.seq == 39 &&
           grow.frames_out + grow.frames_skipped + grow.frames_incomplete + grow.sequence_gaps ==
               40;
  }));
  graph.Look([](Graph& g) { EXPECT_GT(g.statuses["grow"].frames_skipped, 0); });
  graph.WaitUntil(count_answers);
  EXPECT_LE(answered, answered_before + 2);
}

}  // namespace
}  // namespace sprout
