// Who decides on the pixels beside an edge: the images, the seeds around, and the walk from coarse
// to fine.
#include "services/prior/edge_judge.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <random>
#include <span>
#include <vector>

#include "services/prior/census.h"
#include "services/prior/edges.h"

namespace sprout {
namespace {

constexpr int kOne = DisparityImage::kCountsPerPixel;
constexpr int kNear = 12 * kOne;
constexpr int kFar = 3 * kOne;
const cv::Vec3b kRed(20, 30, 200);
const cv::Vec3b kBlue(200, 30, 20);

// A triangle with these seeds around.
EdgeTriangle Edge(std::initializer_list<int> seeds) {
  EdgeTriangle edge;
  std::copy(seeds.begin(), seeds.end(), edge.nearby_seeds.begin());
  edge.nearby_count = seeds.size();
  return edge;
}

// A pair in which every left pixel has one disparity, its left part red and the rest blue. Three
// seeds: one at the left border, near; two at the right one, far.
class Pair {
 public:
  Pair(cv::Size size, int disparity, int first_blue) : colours_(size, kRed) {
    colours_.colRange(first_blue, size.width) = kBlue;
    std::mt19937 random(1);
    evidence.left_grey = cv::Mat1b(size);
    evidence.right_grey = cv::Mat1b(size, uint8_t{0});
    for (int v = 0; v < size.height; ++v) {
      for (int u = 0; u < size.width; ++u) {
        const auto grey = static_cast<uint8_t>(random() % 256);
        evidence.left_grey(v, u) = grey;
        if (u >= disparity) evidence.right_grey(v, u - disparity) = grey;
      }
    }
    const auto right = static_cast<float>(size.width - 1);
    const auto bottom = static_cast<float>(size.height - 1);
    planes_ = {{.u = 0, .v = 0, .disparity = 12},
               {.u = right, .v = 0, .disparity = 3},
               {.u = right, .v = bottom, .disparity = 3}};
    votes_.Look(std::vector{Edge({0, 1, 2})}, planes_, std::sqrt(size.area() / 3.0), colours_);
    evidence.left_bgr = colours_;
    evidence.seeds = &votes_;
    Look();
  }

  void TakeTextureAway() {
    evidence.left_grey = 90;
    evidence.right_grey = 90;
    Look();
  }

  void Look() {
    CensusTransform(evidence.left_grey, evidence.left_census);
    CensusTransform(evidence.right_grey, evidence.right_census);
  }

  bool IsNear(int u, int v, int near, int far) const {
    return EdgeJudge(evidence).IsNear({u, v, near, far}, 0);
  }

  EdgeEvidence evidence{};

 private:
  cv::Mat3b colours_;
  std::vector<LocalPlane> planes_;
  SeedVotes votes_;
};

TEST(EdgeJudge, FindsTheDisparityThatTheImagesHave) {
  const cv::Size size(51, 33);
  for (const int truth : {12, 3}) {
    for (const double census : {0.0, 1.2}) {
      Pair pair(size, truth, 20);
      pair.evidence.weights.census = census;
      for (int v = 0; v < size.height; ++v) {
        for (int u = 12; u < size.width; ++u) {
          EXPECT_EQ(pair.IsNear(u, v, kNear, kFar), truth == 12) << u << ", " << v;
        }
      }
    }
  }
}

TEST(EdgeJudge, SeesTheSameInACameraOfAnotherExposure) {
  Pair pair({51, 33}, 12, 20);
  pair.evidence.right_grey = pair.evidence.right_grey / 2 + 100;
  pair.Look();
  pair.evidence.weights.census = 20;
  for (int u = 16; u < 47; ++u) EXPECT_TRUE(pair.IsNear(u, 16, kNear, kFar)) << u;
}

TEST(EdgeJudge, HoldsNothingOfHypothesesThatLeaveTheRightImage) {
  const Pair pair({51, 33}, 3, 20);
  for (int u = 3; u < 51; ++u) {
    EXPECT_FALSE(pair.IsNear(u, 0, 1023 * kOne, kFar));
    EXPECT_FALSE(pair.IsNear(u, 16, 1023 * kOne, 1000 * kOne));  // neither: the far one
  }
}

TEST(EdgeJudge, AsksTheSeedsOfItsColourWhereThereIsNoTexture) {
  Pair pair({51, 33}, 3, 40);
  pair.TakeTextureAway();
  for (int u = 15; u < 51; ++u) {
    EXPECT_FALSE(pair.IsNear(u, 16, kNear, kFar)) << u;  // nobody votes: the far one
    pair.evidence.weights.colour = 1;
    EXPECT_EQ(pair.IsNear(u, 16, kNear, kFar), u < 40) << u;
    pair.evidence.weights.colour = 0;
  }
}

TEST(EdgeJudge, AsksTheSeedsCloseByWhereColoursAreAlike) {
  Pair pair({51, 33}, 3, 51);
  pair.TakeTextureAway();
  pair.evidence.weights.proximity = 1;
  EXPECT_TRUE(pair.IsNear(15, 1, kNear, kFar));
  EXPECT_FALSE(pair.IsNear(40, 1, kNear, kFar));
  EXPECT_FALSE(pair.IsNear(40, 31, kNear, kFar));
}

// Votes at pixel (5, 5), which is red, as the seeds there are, 5 px apart.
SeedVotes::Votes VotesOf(std::initializer_list<int> seeds, const std::vector<LocalPlane>& planes,
                         int near, int far, cv::Point pixel = {5, 5}) {
  SeedVotes votes;
  votes.Look(std::vector{Edge({}), Edge(seeds)}, planes, 5, cv::Mat3b(20, 10, kRed));
  return votes.Of(1, pixel, kRed, near, far);
}

TEST(SeedVotes, AreSharesAndNoSeedsHaveNone) {
  const std::vector<LocalPlane> planes(6, {.u = 5, .v = 5, .disparity = 12});
  for (const auto& seeds : {std::initializer_list<int>{0}, {0, 1, 2, 3}, {0, 1, 2, 3, 4}}) {
    EXPECT_NEAR(VotesOf(seeds, planes, kNear, kFar).colour, 1, 0.01);
    EXPECT_NEAR(VotesOf(seeds, planes, kNear, kFar).proximity, 1, 0.01);
    EXPECT_NEAR(VotesOf(seeds, planes, 18 * kOne, kNear).colour, -1, 0.01);
    EXPECT_NEAR(VotesOf(seeds, planes, 18 * kOne, kNear).proximity, -1, 0.01);
  }
  EXPECT_EQ(VotesOf({}, planes, kNear, kFar).colour, 0);
  EXPECT_EQ(VotesOf({}, planes, kNear, kFar).proximity, 0);
}

TEST(SeedVotes, WeighColoursAndDistances) {
  cv::Mat3b image(20, 40, kRed);
  image.colRange(20, 40) = kBlue;
  // One seed like the pixel far away, one of another colour beside it.
  const std::vector<LocalPlane> planes = {{.u = 2, .v = 5, .disparity = 12},
                                          {.u = 22, .v = 5, .disparity = 3}};
  SeedVotes votes;
  votes.Look(std::vector{Edge({0, 1})}, planes, 5, image);
  const SeedVotes::Votes red = votes.Of(0, {19, 5}, kRed, kNear, kFar);
  EXPECT_GT(red.colour, 0.9);
  EXPECT_LT(red.proximity, 0);
  EXPECT_LT(votes.Of(0, {22, 5}, kBlue, kNear, kFar).colour, -0.9);
}

// A floor that rises towards the camera by a pixel a row, in front of a wall. Ten rows below its
// seeds it is nearer than they are.
TEST(SeedVotes, AreForTheSurfaceThatASeedsPlaneLeadsTo) {
  const std::vector<LocalPlane> planes(3, {.u = 5, .v = 5, .disparity = 12, .per_row = 1});
  EXPECT_NEAR(VotesOf({0, 1, 2}, planes, 22 * kOne, kNear, {5, 15}).colour, 1, 0.01);
  EXPECT_NEAR(VotesOf({0, 1, 2}, planes, 22 * kOne, kNear).colour, -1, 0.01);
}

TEST(SeedVotes, CountLittleOfSeedsOnAThirdSurface) {
  std::vector<LocalPlane> planes(3, {.u = 5, .v = 5, .disparity = 12});
  planes[1].disparity = planes[2].disparity = 3 - 7;  // far behind the far one
  // Two against one, but with a hundredth of a say each.
  EXPECT_NEAR(VotesOf({0, 1, 2}, planes, kNear, kFar).colour, 1 - 4 / 101.0, 0.01);
}

TEST(Census, SaysWhichPixelsAroundAreDarker) {
  const cv::Mat1b image = (cv::Mat1b(3, 3) << 1, 9, 1, 9, 5, 5, 4, 6, 7);
  cv::Mat1b codes;
  CensusTransform(image, codes);
  EXPECT_EQ(codes(1, 1), 0b10100100);
  EXPECT_EQ(codes(0, 0), 0);
  EXPECT_EQ(codes(2, 2), 0);  // on the border
  CensusTransform(cv::Mat1b(1, 1, uint8_t{7}), codes);
  EXPECT_EQ(codes(0, 0), 0);
}

TEST(ResolveEdges, FindsTheEdgeToThePixelAndLeavesTheRest) {
  // Odd sizes, and some for which the wide grid has no cell or hardly one.
  for (const cv::Size size :
       {cv::Size(61, 43), cv::Size(62, 42), cv::Size(3, 2), cv::Size(2, 2), cv::Size(1, 1)}) {
    const int edge = size.width / 2;
    Pair pair(size, 0, edge);
    pair.TakeTextureAway();
    pair.evidence.weights.colour = 100;  // near disparities leave the right image
    const auto constant = [&](int counts) {
      return DisparityImage(cv::Mat1s(size, static_cast<int16_t>(counts)));
    };
    EdgeHypotheses hypotheses{constant(kNear), constant(kFar), cv::Mat1i(size, 0)};
    const int undisputed = size.height > 4 ? 0 : -1;  // row
    if (undisputed == 0) hypotheses.near.counts().row(0) = DisparityImage::kInvalid;
    DisparityImage prior = constant(7 * kOne);
    ResolveEdges(hypotheses, EdgeJudge(pair.evidence), prior);
    for (int v = 0; v < size.height; ++v) {
      for (int u = 0; u < size.width; ++u) {
        const float expected = v == undisputed ? 7.F : (u < edge ? 12.F : 3.F);
        ASSERT_EQ(prior.Px(u, v), expected) << u << ", " << v << " of " << size;
      }
    }
  }
}

// Pixels of even rows and columns are asked first.
TEST(ResolveEdges, DoesNotAskAPixelAmongOthersOnOneSurface) {
  const cv::Size size(31, 31);
  Pair pair(size, 0, size.width - 1);
  pair.TakeTextureAway();
  pair.evidence.weights.colour = 100;
  pair.evidence.left_bgr(15, 7) = kBlue;   // unheard
  pair.evidence.left_bgr(20, 12) = kBlue;  // heard
  DisparityImage prior(cv::Mat1s(size, int16_t{0}));
  const EdgeHypotheses hypotheses{DisparityImage(cv::Mat1s(size, int16_t{kNear})),
                                  DisparityImage(cv::Mat1s(size, int16_t{kFar})),
                                  cv::Mat1i(size, 0)};
  ResolveEdges(hypotheses, EdgeJudge(pair.evidence), prior);
  EXPECT_EQ(prior.Px(7, 15), 12);
  EXPECT_EQ(prior.Px(12, 20), 3);
}

}  // namespace
}  // namespace sprout
