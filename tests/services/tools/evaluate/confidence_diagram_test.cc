#include "services/tools/evaluate/confidence_diagram.h"

#include <gmock/gmock.h>

#include <cmath>

namespace sprout::evaluate {
namespace {

using ::testing::HasSubstr;

// Of 100 pixels `bad` are wrong, and they come last; p is claimed of the last tenth alone.
MethodResult ResultOf(const std::string& name, double bad, double claimed) {
  Sparsification curve;
  for (int i = 1; i <= Sparsification::kSteps; ++i) {
    curve.bad1_percent[static_cast<size_t>(i - 1)] =
        100 * std::max(0.0, 5 * i - (100 - bad)) / (5 * i);
  }
  Calibration calibration;
  calibration.bins.back() = {.claimed_percent = claimed, .bad1_percent = 10 * bad};
  return {.name = name, .confidence = curve, .calibration = calibration};
}

SceneResult SceneWith(const std::string& name, std::vector<MethodResult> methods) {
  return {.name = name, .size = {}, .methods = std::move(methods), .refinement = {}};
}

size_t CountParts(const std::string& text, const std::string& part) {
  size_t count = 0;
  for (size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

// The plots are 260 px wide and high; the left one begins at (56, 56), the right one at 428.
TEST(ConfidenceSvg, DrawsTheMeanOfTheScenes) {
  const std::string svg = ConfidenceSvg(
      {SceneWith("a", {ResultOf("sprout", 4, 60)}), SceneWith("b", {ResultOf("sprout", 8, 100)})});
  EXPECT_EQ(CountParts(svg, "stroke=\"#bbb\""), 4U);
  EXPECT_EQ(CountParts(svg, "stroke-width=\"2.5\""), 2U);
  // Claimed 80 %, true 60 %: axes to 100. 56 + 0.8 · 260 and 56 + 0.4 · 260.
  EXPECT_THAT(svg, HasSubstr(" 264.0,160.0\"/>"));
  // Bad 1 of all 6 %: axis to 10, 56 + 0.4 · 260 at the right end.
  EXPECT_THAT(svg, HasSubstr(" 688.0,160.0\"/>"));
  EXPECT_THAT(svg, HasSubstr("stroke-dasharray=\"5 4\" points=\"56.0,316.0 316.0,56.0\""));
  EXPECT_EQ(svg.rfind("</svg>\n"), svg.size() - 7);
}

TEST(ConfidenceSvg, HasNoReliabilityOfWhatClaimsNoProbability) {
  MethodResult rival = ResultOf("other", 4, 60);
  rival.calibration.reset();
  MethodResult none = ResultOf("a<b", 4, 60);
  none.confidence.reset();
  none.calibration.reset();
  const std::string svg = ConfidenceSvg({SceneWith("a", {rival, none})});
  EXPECT_THAT(svg, HasSubstr(">other</text>"));
  EXPECT_THAT(svg, ::testing::Not(HasSubstr("a&lt;b")));
  EXPECT_EQ(CountParts(svg, "stroke-width=\"2.5\""), 1U);
  EXPECT_EQ(ConfidenceSvg({SceneWith("a", {none})}), "");
}

constexpr int kSide = 100;

// A map whose truth is 10 px; the first `bad` rows are 3 px off, the others 0.2 px.
cv::Mat1f MapWithBadRows(int bad) {
  cv::Mat1f map(kSide, kSide, 10.2F);
  map.rowRange(0, bad) = 13.F;
  return map;
}

const cv::Mat1f kTruth(kSide, kSide, 10.F);
const cv::Mat1b kEverywhere(kSide, kSide, uint8_t{255});

TEST(Calibrate, IsPerfectWhereTheClaimIsTheRate) {
  const cv::Mat1b confidence(kSide, kSide, uint8_t{204});  // p = 0.2
  const cv::Mat1b sigma(kSide, kSide, uint8_t{8});         // 0.5 px
  const Calibration result = Calibrate(MapWithBadRows(20), kTruth, kEverywhere, confidence, sigma);
  EXPECT_NEAR(result.claimed_percent, 20, 1e-9);
  EXPECT_NEAR(result.bad1_percent, 20, 1e-9);
  EXPECT_NEAR(result.error_points, 0, 1e-9);
  EXPECT_NEAR(result.within_1_sigma_percent, 80, 1e-9);
  EXPECT_NEAR(result.within_2_sigma_percent, 80, 1e-9);
}

TEST(Calibrate, SortsPixelsByTheirClaim) {
  cv::Mat1b confidence(kSide, kSide, uint8_t{255});
  confidence.rowRange(0, 10) = uint8_t{0};
  const Calibration result = Calibrate(MapWithBadRows(5), kTruth, kEverywhere, confidence,
                                       cv::Mat1b(kSide, kSide, uint8_t{48}));
  EXPECT_NEAR(result.bins.front().claimed_percent, 0, 1e-9);
  EXPECT_NEAR(result.bins.front().bad1_percent, 0, 1e-9);
  EXPECT_NEAR(result.bins.back().claimed_percent, 100, 1e-9);
  EXPECT_NEAR(result.bins.back().bad1_percent, 50, 1e-9);
  EXPECT_NEAR(result.error_points, 5, 1e-9);
  EXPECT_NEAR(result.within_1_sigma_percent, 100, 1e-9);
}

TEST(Calibrate, LeavesOutWhatClaimsNothing) {
  cv::Mat1f map = MapWithBadRows(50);
  map.rowRange(0, 50) = std::nanf("");
  const cv::Mat1b sure(kSide, kSide, uint8_t{255});
  EXPECT_NEAR(Calibrate(map, kTruth, kEverywhere, sure, sure).bad1_percent, 0, 1e-9);
  const Calibration none = Calibrate(map, kTruth, cv::Mat1b(kSide, kSide, uint8_t{0}), sure, sure);
  EXPECT_TRUE(std::isnan(none.claimed_percent));
  EXPECT_TRUE(std::isnan(none.error_points));
}

}  // namespace

}  // namespace sprout::evaluate
