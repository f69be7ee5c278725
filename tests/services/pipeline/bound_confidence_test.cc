#include "services/pipeline/files/bound_confidence.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/core/prior_map.h"

namespace sprout {
namespace {

using inputs::Findings;
using inputs::Question;
using inputs::Verdict;

inputs::Finding Bad(Question question, double value) {
  return {.question = question, .verdict = Verdict::kBad, .value = value, .sigma = 0.1};
}

// Pixels of 100, 200 and 240 of 255, and one without a disparity.
DepthFrame FrameOfFour() {
  DepthFrame depth;
  depth.disparity = DisparityImage(cv::Size(4, 1));
  for (int u = 0; u < 3; ++u) depth.disparity.counts()(0, u) = ToCounts(20);
  depth.confidence = (cv::Mat1b(1, 4) << 100, 200, 240, 0);
  depth.sigma = (cv::Mat1b(1, 4) << 16, 4, 1, kMaxSigmaCounts);
  depth.kept = DisparityImage(cv::Mat1s(depth.disparity.counts().clone()));
  depth.depth_m = cv::Mat1f(1, 4, 2.0F);
  depth.depth_m(0, 3) = NAN;
  return depth;
}

std::vector<uint8_t> Bounded(const Findings& findings) {
  DepthFrame depth = FrameOfFour();
  BoundConfidence(findings, LoadConfig({"default"}), depth);
  return depth.confidence;
}

TEST(Doubt, BoundsConfidenceByHowFarRowsAreOff) {
  using testing::ElementsAre;
  EXPECT_THAT(Bounded({}), ElementsAre(100, 200, 240, 0));
  EXPECT_THAT(Bounded({{.question = Question::kRows, .verdict = Verdict::kGood, .value = 0.4}}),
              ElementsAre(100, 200, 240, 0));
  EXPECT_THAT(Bounded({Bad(Question::kRows, -2.5)}), ElementsAre(40, 80, 96, 0));
  EXPECT_THAT(Bounded({Bad(Question::kTime, 2), Bad(Question::kRows, 5)}),
              ElementsAre(20, 40, 48, 0));
  EXPECT_THAT(Bounded({Bad(Question::kSides, 90)}), ElementsAre(0, 0, 0, 0));
  EXPECT_THAT(Bounded({Bad(Question::kScene, 1)}), ElementsAre(0, 0, 0, 0));
  EXPECT_THAT(Bounded({Bad(Question::kScale, 3), Bad(Question::kBits, 2)}),
              ElementsAre(100, 200, 240, 0));
}

// Points at 2, 6 and 10 px, a match at 14.
TEST(Doubt, BelievesRangesThatRefineBelievesBesideSuchAPair) {
  const auto bounded = [](bool alone, Question question) {
    DepthFrame depth;
    depth.disparity = DisparityImage(cv::Size(24, 1));
    depth.kept = DisparityImage(cv::Size(24, 1));
    depth.confidence = cv::Mat1b(1, 24, uint8_t{200});
    depth.sigma = cv::Mat1b(1, 24, uint8_t{4});
    depth.depth_m = cv::Mat1f(1, 24, 2.0F);
    for (int16_t i = 0; i < 3; ++i) {
      depth.seeds.seeds.push_back({.u = 2.0F + 4 * i, .tof_u = i, .tof_v = 0});
    }
    depth.seeds.seeds.push_back({.u = 14, .origin = SeedOrigin::kStereo});
    depth.ranges_alone = alone;
    BoundConfidence({Bad(question, 2)}, LoadConfig({"default"}), depth);
    EXPECT_EQ(depth.sigma(0, 0) == 4, depth.confidence(0, 0) == 200);
    return std::vector<uint8_t>(depth.confidence);
  };
  std::vector<uint8_t> some(24, 100);
  std::fill_n(some.begin(), 10, uint8_t{200});
  EXPECT_EQ(bounded(true, Question::kRows), some);
  EXPECT_EQ(bounded(false, Question::kRows), std::vector<uint8_t>(24, 100));
  EXPECT_EQ(bounded(true, Question::kScene), std::vector<uint8_t>(24, 0));
}

TEST(Doubt, AddsToTheStandardDeviation) {
  DepthFrame depth = FrameOfFour();
  BoundConfidence({Bad(Question::kRows, 3)}, LoadConfig({"default"}), depth);
  EXPECT_EQ(depth.sigma(0, 0), 32);  // 1 and √3 px
  EXPECT_EQ(depth.sigma(0, 2), 28);
  EXPECT_EQ(depth.sigma(0, 3), kMaxSigmaCounts);
  DepthFrame other = FrameOfFour();
  BoundConfidence({Bad(Question::kScene, 1)}, LoadConfig({"default"}), other);
  EXPECT_EQ(other.sigma(0, 0), kMaxSigmaCounts);
}

TEST(Doubt, LeavesOutWhatIsLessSureThanAsked) {
  const Findings findings = {Bad(Question::kRows, 2)};
  DepthFrame depth = FrameOfFour();
  BoundConfidence(findings, LoadConfig({"default", "grow { min_confidence: 90 }"}), depth);
  EXPECT_FALSE(depth.disparity.IsValid(0, 0));  // 50
  EXPECT_TRUE(depth.disparity.IsValid(1, 0));   // 100
  EXPECT_TRUE(std::isnan(depth.depth_m(0, 0)));
  EXPECT_FALSE(std::isnan(depth.depth_m(0, 1)));
  depth = FrameOfFour();
  BoundConfidence(findings, LoadConfig({"default", "depth { min_confidence: 110 }"}), depth);
  EXPECT_TRUE(depth.disparity.IsValid(0, 0));
  EXPECT_TRUE(std::isnan(depth.depth_m(0, 1)));
  EXPECT_FALSE(std::isnan(depth.depth_m(0, 2)));  // 120
}

TEST(Doubt, NeedsNoConfidence) {
  DepthFrame depth = FrameOfFour();
  depth.confidence.release();
  depth.sigma.release();
  BoundConfidence({Bad(Question::kRows, 2)}, LoadConfig({"fast"}), depth);
  EXPECT_TRUE(depth.confidence.empty());
  EXPECT_TRUE(depth.disparity.IsValid(0, 0));
}

}  // namespace
}  // namespace sprout
