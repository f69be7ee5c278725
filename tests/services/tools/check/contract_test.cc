#include "services/tools/check/contract.h"

#include <gtest/gtest.h>

namespace sprout::check {
namespace {

const RectifiedPair kConverged{
    .width = 64, .height = 48, .focal_px = 60, .cx = 30, .cx_right = 38, .baseline_m = 0.1};

bool Passes(const PartValue& answer) {
  Findings found;
  CheckAnswer(answer, kConverged, "the answer", found);
  return found.empty();
}

TEST(Contract, DisparitiesOfAConvergedPairReachToInfinity) {
  const auto map_of = [](double disparity_px) {
    return DisparityImage(cv::Mat1s(kConverged.size(), ToCounts(disparity_px)));
  };
  EXPECT_TRUE(Passes(map_of(-8)));
  EXPECT_FALSE(Passes(map_of(-10)));
  const auto seeds_of = [](float disparity_px) {
    return SeedSet{.seeds = {{.u = 20, .v = 9, .u_right = 20 - disparity_px}}, .raw = 1};
  };
  EXPECT_TRUE(Passes(seeds_of(-8)));
  EXPECT_FALSE(Passes(seeds_of(-10)));
}

TEST(Contract, AConfidenceIsNoProbability) {
  const auto passes = [](uint8_t largest) {
    cv::Mat1b confidence(kConverged.size(), uint8_t{0});
    confidence(7, 9) = largest;
    Findings found;
    CheckExtra(Part::kConfidence, cv::Mat(confidence), kConverged, "the confidence", found);
    return found.empty();
  };
  EXPECT_FALSE(passes(1));
  EXPECT_TRUE(passes(2));
  EXPECT_TRUE(passes(0)) << "nothing is sure";
}

}  // namespace
}  // namespace sprout::check
