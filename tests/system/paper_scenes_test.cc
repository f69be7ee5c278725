#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>

#include "common/scenes/dataset.h"
#include "tests/system/graph.h"
#include "tests/system/in_process.h"

namespace sprout {
namespace {

class PaperScenes : public testing::TestWithParam<const char*> {};

// The paper's scenes through the four processes: EPC 88.8 / 85.2 / 88.7, filled 96.4 / 95.3 / 98.2,
// D_p 92.9 / 92.1 / 96.0 (its table; share of correct non-occluded pixels, error ≤ 1 px).
TEST_P(PaperScenes, ComeOutAsInThePaper) {
  const char* data = std::getenv("SPROUT_DATA");
  if (data == nullptr) {
    GTEST_SKIP() << "PaperScenes/" << GetParam()
                 << ": SPROUT_DATA is not set; scripts/fetch_middlebury gets the scenes";
  }
  const std::string source = std::string("middlebury:") + data + "/middlebury/full/" + GetParam();
  const std::string overrides =
      (std::filesystem::path(SPROUT_BINARY_DIR) / "publish_unfilled.textproto").string();
  std::ofstream(overrides) << "grow { publish_unfilled: true }\n";
  Graph graph;
  graph.StartChain({"--config", "paper", "--config", overrides});
  graph.Capture({"--config", "paper", "--source", source, "--frames", "1"},
                std::chrono::seconds(60));
  ASSERT_TRUE(graph.WaitUntil([](Graph& g) {
    return g.parts.contains({Part::kDisparity, 0}) && g.statuses["grow"].frames_out == 1;
  }));

  const scenes::GroundTruth truth = scenes::OpenDataset(source)->Get(0).truth;
  graph.Look([&](Graph& g) {
    const auto correct = [&](Part part) {
      const PartValue& value = g.parts.at({part, 0});
      const auto* prior = std::get_if<PriorMap>(&value);
      return CorrectPercent(prior ? prior->disparity : std::get<DisparityImage>(value), truth);
    };
    const double prior = correct(Part::kPrior);
    const double grown = correct(Part::kUnfilled);
    const double filled = correct(Part::kDisparity);
    std::cout << GetParam() << ": prior " << prior << ", grown " << grown << ", filled " << filled
              << "; age " << g.statuses["grow"].age.max_ms << " ms\n";
    EXPECT_GE(prior, 92);
    EXPECT_LE(prior, 98);
    EXPECT_GE(grown, 83);
    EXPECT_LE(grown, 95);
    EXPECT_GE(filled, 93);
    EXPECT_LE(filled, 99);
    for (const auto& [stage, status] : g.statuses) {
      std::cout << "  " << stage << ": " << status.rss_bytes / 1000000 << " MB\n";
      EXPECT_LT(status.rss_bytes, 300'000'000) << stage;
    }
  });
}

INSTANTIATE_TEST_SUITE_P(System, PaperScenes, testing::Values("Lampshade1", "Monopoly", "Plastic"));

}  // namespace
}  // namespace sprout
