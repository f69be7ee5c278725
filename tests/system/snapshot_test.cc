#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>

#include "tests/common/picture/temporary_directory.h"
#include "tests/system/graph.h"

namespace sprout {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr char kSource[] = "synthetic:160x120";

TEST(SnapshotSystem, WritesTheLastFrameOfTheRunningGraph) {
  const TemporaryDirectory directory;
  const std::string overrides = (directory / "overrides.textproto").string();
  std::ofstream(overrides) << "grow { publish_unfilled: true }\n";
  const std::string out = (directory / "out").string();
  Graph graph;
  for (const char* stage : {"refine", "prior", "grow"}) {
    graph.Start(stage, {"--config", "default", "--config", overrides});
  }
  Process& snapshot = graph.Start(
      "snapshot", {"--out", out, "--frames", "3", "--timeout", "30", "--source", kSource});
  graph.StartOnly("capture", {"--source", kSource, "--frames", "3", "--lockstep", "1", "--wait-for",
                              "refine,prior,grow,snapshot"});
  ASSERT_EQ(snapshot.Wait(std::chrono::seconds(60)), 0) << snapshot.Output();
  EXPECT_THAT(snapshot.Output(), AllOf(HasSubstr("refine"), HasSubstr("prior"), HasSubstr("grow")));

  const cv::Mat1f px = cv::imread(out + "/disparity.pfm", cv::IMREAD_UNCHANGED);
  ASSERT_TRUE(graph.WaitUntil([](Graph& g) { return g.parts.contains({Part::kDisparity, 2}); }));
  graph.WaitUntil([&](Graph& g) {
    const auto& map = std::get<DisparityImage>(g.parts.at({Part::kDisparity, 2}));
    EXPECT_EQ(px.size(), map.size());
    EXPECT_EQ(cv::countNonZero(px == ToPx(map)), map.CountValid());
    EXPECT_GT(map.CountValid(), map.size().area() / 2);
    return true;
  });
  for (const char* file : {"left.png", "tof.png", "seeds.png", "prior.png", "disparity_filled.png",
                           "confidence.png", "errors.png", "overview.png"}) {
    EXPECT_FALSE(cv::imread(out + "/" + file).empty()) << file;
  }
  for (const char* file : {"cloud.ply", "mesh.ply"}) {
    EXPECT_GT(std::filesystem::file_size(out + "/" + file), 10'000U) << file;
  }
}

TEST(SnapshotSystem, WorksWithAGrowerThatSendsTheMapAlone) {
  const TemporaryDirectory directory;
  const std::string out = (directory / "out").string();
  Graph graph;
  for (const char* stage : {"refine", "prior", "grow"}) graph.Start(stage, {"--config", "fast"});
  Process& snapshot = graph.Start("snapshot", {"--out", out, "--timeout", "30"});
  graph.StartOnly("capture", {"--source", kSource, "--frames", "1", "--lockstep", "1", "--wait-for",
                              "refine,prior,grow,snapshot"});
  ASSERT_EQ(snapshot.Wait(std::chrono::seconds(60)), 0) << snapshot.Output();
  EXPECT_THAT(snapshot.Output(),
              AllOf(HasSubstr("no SPROUT_UNFILLED"), HasSubstr("no SPROUT_CONFIDENCE")));
  EXPECT_FALSE(cv::imread(out + "/overview.png").empty());
}

TEST(SnapshotSystem, SaysHowManyFramesCameWhenTheGraphIsSilent) {
  const TemporaryDirectory directory;
  Graph graph;
  Process& snapshot =
      graph.StartOnly("snapshot", {"--out", (directory / "out").string(), "--timeout", "0.5"});
  EXPECT_EQ(snapshot.Wait(std::chrono::seconds(20)), 1);
  EXPECT_THAT(snapshot.Output(),
              AllOf(HasSubstr("0 of 1 frames arrived with all their parts in 0.5 s"),
                    HasSubstr("nothing on SPROUT_LEFT, SPROUT_RIGHT, SPROUT_TOF, SPROUT_RIG")));
}

}  // namespace
}  // namespace sprout
