#include "services/tools/evaluate/calibration.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sprout::evaluate {
namespace {

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
