// Programs that people use beside the stages: depth and clouds as messages, the board of statuses.
#include <gmock/gmock.h>

#include <csignal>
#include <nlohmann/json.hpp>

#include "common/scenes/dataset.h"
#include "services/depth/depth_map.h"
#include "tests/system/eventually.h"
#include "tests/system/graph.h"
#include "tests/system/run_program.h"

namespace sprout {
namespace {

using ::testing::HasSubstr;

constexpr char kUsersSource[] = "synthetic:320x240";

TEST(DepthSystem, TurnsEveryMapIntoDepthAndPoints) {
  Graph graph;
  graph.StartChain();
  graph.Start("depth", {"--config", "default"});
  graph.Capture({"--source", kUsersSource, "--frames", "3"});
  const auto source = scenes::OpenDataset(kUsersSource);
  ASSERT_TRUE(graph.WaitUntil([](Graph& g) { return g.parts.contains({Part::kCloud, 2}); }));
  graph.Look([&](Graph& g) {
    for (int64_t seq = 0; seq < 3; ++seq) {
      const auto& map = std::get<DisparityImage>(g.parts.at({Part::kDisparity, seq}));
      const auto& depth = std::get<DepthImage>(g.parts.at({Part::kDepth, seq}));
      const DepthImage expected = depth::DepthOf(map, source->rig().pair, 0.001, 1);
      EXPECT_EQ(cv::countNonZero(depth.counts != expected.counts), 0);
      EXPECT_GT(cv::countNonZero(depth.counts), 320 * 240 / 2);
      EXPECT_GT(std::get<PointCloud>(g.parts.at({Part::kCloud, seq})).points.size(), 80 * 60 / 2U);
    }
  });
}

// The example of a capture process, which uses LCM's library alone.
TEST(CaptureExampleSystem, LeadsToADepthMapOfItsWall) {
  Graph graph;
  graph.StartChain();
  const Process camera({ProgramPath("camera_example")});
  ASSERT_TRUE(graph.WaitUntil([](Graph& g) { return g.statuses["grow"].frames_out >= 3; }));
  graph.Look([](Graph& g) {
    for (const auto& [key, value] : g.parts) {
      if (key.first != Part::kDisparity) continue;
      const auto& map = std::get<DisparityImage>(value);
      int close = 0;
      for (int v = 0; v < map.height(); ++v) {
        for (int u = 0; u < map.width(); ++u) {
          close += map.IsValid(u, v) && std::abs(map.Px(u, v) - 15) < 0.1F;
        }
      }
      EXPECT_GT(close, 0.9 * map.width() * map.height()) << "frame " << key.second;
    }
  });
}

class TopSystem : public ::testing::Test {
 protected:
  // Exit code of sprout-top and what it says, as one object.
  std::pair<int, nlohmann::json> Look(const std::string& stages) {
    const auto [code, output] =
        RunProgramOf({"sprout-top", "--once", "--json", "--log-level", "error", "--stages", stages},
                     std::chrono::seconds(30));
    const size_t start = output.find('{');
    EXPECT_NE(start, std::string::npos) << output;
    return {code, nlohmann::json::parse(output.substr(std::min(start, output.size())), nullptr,
                                        /*allow_exceptions=*/false)};
  }

  Graph graph_;
};

TEST_F(TopSystem, SaysWhetherEveryStageIsThereOnce) {
  graph_.StartChain();
  const auto [good, board] = Look("refine,prior,grow");
  EXPECT_EQ(good, 0) << board;
  EXPECT_TRUE(board["whole"]);
  EXPECT_EQ(board["stages"][2]["pid"], graph_.process("grow").pid());

  const auto [missing, without] = Look("capture,refine");
  EXPECT_EQ(missing, 1);
  EXPECT_EQ(without["stages"][0]["health"], "missing");

  const Process second({ProgramPath("sprout-grow"), "--config", "default"});
  ASSERT_TRUE(graph_.WaitUntil([&](Graph& g) { return g.statuses["grow"].pid == second.pid(); }));
  const auto [twice, both] = Look("refine,prior,grow");
  EXPECT_EQ(twice, 1);
  EXPECT_EQ(both["stages"][2]["health"], "twice") << both;
}

TEST_F(TopSystem, SaysWhoFellSilent) {
  graph_.StartChain();
  Process top({ProgramPath("sprout-top"), "--stages", "refine"});
  ASSERT_TRUE(Says(top, "refine     good")) << top.Output();
  graph_.process("refine").Signal(SIGSTOP);
  EXPECT_TRUE(Says(top, "refine     stale")) << top.Output();
  top.Signal(SIGINT);
  EXPECT_EQ(top.Wait(), 1);
  graph_.process("refine").Signal(SIGCONT);
}

// What sprout-refine finds in the frames that it is sent is in the status, for sprout-top and the
// page, and counts; its seeds go out all the same.
TEST_F(TopSystem, SaysWhatInAFrameDoesNotFit) {
  graph_.Start("refine", {"--config", "default", "--config", "refine { check_inputs_every: 1 }"});
  const auto source = scenes::OpenDataset("synthetic:640x480?tof=grid");
  const Rig rig = source->rig();
  int64_t seq = 0;
  const auto send = [&](const cv::Mat& left, const cv::Mat& right, const TofImage& tof) {
    graph_.PublishFrame(1000 + seq, seq, rig, left, right, tof);
    ++seq;
    EXPECT_TRUE(graph_.WaitUntil([&](Graph& g) {
      return g.statuses["refine"].frames_out == seq &&
             g.part_counts.contains({Part::kSeeds, seq - 1});
    })) << seq;
    return Look("refine").second["stages"][0];
  };
  const scenes::DatasetFrame frame = source->Get(0);
  nlohmann::json row = send(frame.right, frame.left, frame.tof);
  EXPECT_THAT(row["last_error"].get<std::string>(), HasSubstr("left and right are swapped"));
  EXPECT_EQ(row["frames_degenerate"], 1) << row;
  TofImage in_mm;
  in_mm.depth_m = frame.tof.depth_m * 1000;
  row = send(frame.left, frame.right, in_mm);
  EXPECT_THAT(row["last_error"].get<std::string>(), HasSubstr("are they in mm, and read as m"));
  EXPECT_EQ(row["frames_degenerate"], 2) << row;
  row = send(frame.left, frame.right, frame.tof);
  EXPECT_EQ(row["frames_degenerate"], 2) << row;
}

class SilenceSystem : public ::testing::Test {
 protected:
  // Whether the newest complaint of a stage has this in it, soon.
  bool Says(const std::string& stage, const std::string& text) {
    return graph_.WaitUntil(
        [&](Graph& g) { return g.statuses[stage].last_error.find(text) != std::string::npos; });
  }

  Graph graph_;
};

TEST_F(SilenceSystem, NamesTheChannelThatIsMissingAndThePrefixThatHasIt) {
  graph_.Start("refine");
  graph_.Start("prior");
  graph_.StartOnly("capture", {"--source", kUsersSource, "--rate", "5", "--channel-prefix", "B_"});
  EXPECT_TRUE(Says("refine", "nothing heard on SPROUT_LEFT, SPROUT_RIGHT, SPROUT_TOF, SPROUT_RIG"));
  EXPECT_TRUE(Says("refine", "with another --channel-prefix: B_SPROUT_LEFT"));
  EXPECT_TRUE(Says("prior", "SPROUT_SEEDS"));
}

TEST_F(SilenceSystem, TellsBothOfTwoProcessesOfOneStage) {
  graph_.Start("grow");
  Process second({ProgramPath("sprout-grow")});
  EXPECT_TRUE(Says("grow", "another sprout-grow works on these channels"));
  EXPECT_TRUE(graph_.WaitUntil(
      [&](Graph&) { return second.Output().find("another sprout-grow") != std::string::npos; },
      std::chrono::seconds(20)))
      << second.Output();
}

TEST_F(SilenceSystem, CaptureSaysThatItCannotKeepItsRate) {
  Process& capture = graph_.StartOnly(
      "capture", {"--source", "synthetic:1280x960", "--rate", "100", "--frames", "60"});
  EXPECT_EQ(capture.Wait(std::chrono::seconds(60)), 0);
  EXPECT_THAT(capture.Output(), HasSubstr("the rate of 100 Hz is not reached"));
}

}  // namespace
}  // namespace sprout
