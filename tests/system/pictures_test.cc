// A person records a running graph, then looks at the log.
#include <gmock/gmock.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>

#include "tests/common/picture/temporary_directory.h"
#include "tests/system/graph.h"
#include "tests/system/run_program.h"

namespace sprout {
namespace {

using testing::AllOf;
using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;

constexpr char kSmallSource[] = "synthetic:160x120";

// Three frames through the graph, beside a recorder; @returns the path of the log.
std::string RecordThreeFrames(Graph& graph, const std::vector<std::string>& stage_flags,
                              const std::filesystem::path& folder) {
  graph.StartChain(stage_flags);
  graph.Start("record", {"--dir", folder.string()});
  graph.Capture({"--source", kSmallSource, "--frames", "3"}, std::chrono::seconds(60));
  for (const char* stage : {"refine", "prior", "grow", "record"}) {
    graph.process(stage).Signal(SIGINT);
    EXPECT_EQ(graph.process(stage).Wait(), 0) << graph.process(stage).Output();
  }
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() == ".lcm") return entry.path().string();
  }
  ADD_FAILURE() << "no log in " << folder;
  return {};
}

TEST(PicturesSystem, ShowARecordedFrame) {
  const TemporaryDirectory directory;
  const std::string overrides = (directory / "overrides.textproto").string();
  std::ofstream(overrides) << "grow { publish_unfilled: true }\n";
  Graph graph;
  const std::string log =
      RecordThreeFrames(graph, {"--config", "default", "--config", overrides}, directory / "logs");

  // A table of how every process fared, as sprout-top has it.
  EXPECT_THAT(OutputOf({"sprout-log", "info", log}),
              AllOf(ContainsRegex("capture +stopped +2 "), ContainsRegex("grow +stopped +2 ")));

  const std::string out = (directory / "out").string();
  const std::string said =
      OutputOf({"sprout-log", "images", log, out, "--truth", kSmallSource, "--frames", "2"});
  EXPECT_THAT(
      said, AllOf(HasSubstr("seeds of frame 2: "), ContainsRegex("filled +1 +100.00 +9[0-9.]+\n")));
  for (const char* file : {"left", "tof", "seeds_raw", "seeds", "prior", "prior_sigma", "unfilled",
                           "disparity", "confidence", "sigma", "cloud", "errors", "overview"}) {
    EXPECT_FALSE(cv::imread(out + "/000002_" + file + ".png").empty()) << file;
  }

  OutputOf({"sprout-log", "export", log, out, "--ply", "--mesh", "--pfm", "--frames", "2"});
  for (const char* file : {"cloud.ply", "mesh.ply"}) {
    EXPECT_GT(std::filesystem::file_size(out + "/000002_" + file), 10'000U) << file;
  }
  const cv::Mat1f px = cv::imread(out + "/000002_disparity.pfm", cv::IMREAD_UNCHANGED);
  graph.Look([&](Graph& g) {
    const auto& map = std::get<DisparityImage>(g.parts.at({Part::kDisparity, 2}));
    EXPECT_EQ(px.size(), map.size());
    EXPECT_EQ(cv::countNonZero(px == ToPx(map)), map.CountValid());
    EXPECT_GT(map.CountValid(), map.size().area() / 2);
  });
}

TEST(PicturesSystem, LeaveOutWhatAGrowerDoesNotSend) {
  const TemporaryDirectory directory;
  Graph graph;
  const std::string log = RecordThreeFrames(graph, {"--config", "fast"}, directory / "logs");
  const std::string out = (directory / "out").string();
  EXPECT_THAT(
      OutputOf({"sprout-log", "images", log, out}),
      AllOf(ContainsRegex("filled +3 "), Not(HasSubstr("correct")), Not(HasSubstr("as grown"))));
  EXPECT_FALSE(cv::imread(out + "/000002_overview.png").empty());
  EXPECT_FALSE(std::filesystem::exists(out + "/000002_confidence.png"));
  EXPECT_FALSE(std::filesystem::exists(out + "/000002_errors.png"));
}

}  // namespace
}  // namespace sprout
