// The rule of the sweeps by hand. The fast one must equal this file's subject: fast_growth_test.cc.
#include <gtest/gtest.h>

#include <vector>

#include "services/grow/paper/plain_growth.h"
#include "tests/common/core/even_prior.h"
#include "tests/services/grow/grow_scenes.h"

namespace sprout::grow {
namespace {

// Everything fits everywhere, so that costs are the distances from the prior alone, which is empty
// but for the pixels that a test gives one.
class Sweep : public testing::Test {
 protected:
  Sweep() {
    config_.set_sigma_p_px(0.7);
    config_.set_sigma_p_noise(0);
    config_.set_sub_pixel(false);
  }

  // A pixel to which the prior leaves the disparity `px` rounded, and a cost that grows with how
  // far off that is.
  void SetPrior(int u, int v, double px) { prior_.counts()(v, u) = ToCounts(px); }

  DisparityImage Run(const std::vector<Correspondence>& seeds) const {
    const PriorMap prior = EvenPrior(prior_, 0.1);
    return SweepPlainly(MakeGrowthRule(config_), {flat_, flat_, prior}, seeds);
  }

  GrowConfig config_;
  const cv::Mat1b flat_ = cv::Mat1b(9, 40, uint8_t{100});
  DisparityImage prior_{cv::Size(40, 9)};
};

TEST_F(Sweep, MatchesWhatSeedsReach) {
  SetPrior(10, 4, 3.2);
  EXPECT_EQ(Run({{9, 4, 3}}).Px(10, 4), 3) << "from the left";
  EXPECT_EQ(Run({{11, 4, 4}}).Px(10, 4), 3) << "from the right, one disparity off";
  EXPECT_EQ(Run({{10, 3, 2}}).Px(10, 4), 3) << "from above";
  EXPECT_EQ(Run({{10, 5, 3}}).Px(10, 4), 3) << "from below";
  EXPECT_EQ(Run({{10, 4, 3}}).CountValid(), 0) << "a seed does not reach itself";
  EXPECT_EQ(Run({{9, 4, 5}}).CountValid(), 0) << "two disparities off";
  EXPECT_EQ(Run({}).CountValid(), 0);
}

TEST_F(Sweep, TheBetterClaimOnARightPixelWins) {
  SetPrior(10, 4, 3.1);  // right pixel 7
  SetPrior(11, 4, 4.0);
  const DisparityImage map = Run({{9, 4, 3}, {12, 4, 4}});
  EXPECT_FALSE(map.IsValid(10, 4));
  EXPECT_EQ(map.Px(11, 4), 4);
}

TEST_F(Sweep, OfTwoEqualClaimsNoneWins) {
  SetPrior(10, 4, 3.0);
  SetPrior(11, 4, 4.0);
  EXPECT_EQ(Run({{9, 4, 3}, {12, 4, 4}}).CountValid(), 0);
  SetPrior(12, 4, 5.1);  // a worse one does not either
  EXPECT_EQ(Run({{9, 4, 3}, {13, 4, 5}}).CountValid(), 0);
}

TEST_F(Sweep, GoesOnAsLongAsNeighboursAreWithinOneDisparity) {
  for (int u = 10; u < 20; ++u) SetPrior(u, 4, 2);
  for (int u = 20; u < 25; ++u) SetPrior(u, 4, 3);  // 20 − 3 = 17 = 19 − 2: nobody
  for (int v = 5; v < 7; ++v) SetPrior(18, v, v - 2);
  const DisparityImage map = Run({{9, 4, 2}});
  EXPECT_EQ(map.Px(18, 4), 2);
  EXPECT_FALSE(map.IsValid(19, 4));
  EXPECT_FALSE(map.IsValid(21, 4)) << "there is a gap before it";
  EXPECT_EQ(map.Px(18, 5), 3);
  EXPECT_EQ(map.Px(18, 6), 4);
  EXPECT_TRUE(Run({{9, 4, 2}, {26, 4, 3}}).IsValid(11, 4));
  EXPECT_TRUE(Run({{25, 4, 3}}).IsValid(21, 4));
}

// A surface at 2 px up to column 12; (13, 4) continues it, but loses its right pixel 11 to (17, 4),
// which no seed reaches.
TEST_F(Sweep, AClaimThatLostAgainstWhatIsErasedIsTakenUpFromItsNeighbour) {
  for (int u = 10; u < 13; ++u) SetPrior(u, 4, 2);
  SetPrior(13, 4, 2.2);
  SetPrior(17, 4, 6);
  const DisparityImage map = Run({{9, 4, 2}});
  EXPECT_EQ(map.Px(13, 4), 2);
  EXPECT_FALSE(map.IsValid(17, 4));
  EXPECT_FALSE(Run({{9, 4, 2}, {18, 4, 6}}).IsValid(13, 4)) << "now (17, 4) stays";
  SetPrior(12, 4, 9);
  EXPECT_FALSE(Run({{9, 4, 2}}).IsValid(13, 4)) << "nothing beside it";
}

TEST_F(Sweep, FromTheRightAsWell) {
  SetPrior(12, 4, 2.2);
  for (int u = 13; u < 16; ++u) SetPrior(u, 4, 2);
  SetPrior(18, 4, 8);  // right pixel 10, as (12, 4)
  EXPECT_EQ(Run({{16, 4, 2}}).Px(12, 4), 2);
}

TEST_F(Sweep, OfClaimsOnAPixelThatIsFreeAgainTheBetterOneComesFirst) {
  for (int u = 10; u < 13; ++u) SetPrior(u, 4, 2);
  SetPrior(13, 4, 2.3);
  SetPrior(14, 4, 3.2);  // the same right pixel, 11; nothing beside it
  SetPrior(17, 4, 6);
  EXPECT_FALSE(Run({{9, 4, 2}}).IsValid(13, 4)) << "the better one has no neighbour";
}

TEST_F(Sweep, LeavesOpenPixelsAlone) {
  config_.set_sigma_p_px(7);
  SetPrior(10, 4, 3);
  EXPECT_EQ(Run({{9, 4, 3}}).CountValid(), 0);
}

TEST_F(Sweep, TakesTheBestOfAllThatAnUnsurePriorLeaves) {
  cv::Mat1b left(flat_.size());
  cv::RNG(7).fill(left, cv::RNG::UNIFORM, 0, 256);
  cv::Mat1b right(flat_.size(), uint8_t{0});
  left.colRange(6, 40).copyTo(right.colRange(0, 34));
  SetPrior(20, 4, 3.4);
  const PriorMap prior = EvenPrior(prior_, 0.1);
  const auto run = [&](double sigma_p_px) {
    config_.set_sigma_p_px(sigma_p_px);
    return SweepPlainly(MakeGrowthRule(config_), {left, right, prior},
                        std::vector<Correspondence>{{19, 4, 6}});
  };
  EXPECT_EQ(run(3).Px(20, 4), 6);
  EXPECT_FALSE(run(1.5).IsValid(20, 4)) << "2.6 px are too far";
}

TEST_F(Sweep, TakesTheLowerOneOfTwoEqualCandidates) {
  SetPrior(10, 4, 3.5);
  EXPECT_EQ(Run({{9, 4, 3}}).Px(10, 4), 3);
}

}  // namespace
}  // namespace sprout::grow
