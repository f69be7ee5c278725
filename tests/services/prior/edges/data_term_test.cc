// The data term of the two labels of a pixel, and the decision between them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>
#include <string>

#include "services/prior/edges/data_term_kernel.h"
#include "services/prior/edges/edge_surfaces.h"
#include "tests/common/testing/instruction_sets.h"

namespace sprout::prior {
namespace {

constexpr int kOnePx = DisparityImage::kCountsPerPixel;
constexpr int kNearCounts = 12 * kOnePx;
constexpr int kFarCounts = 3 * kOnePx;
const cv::Vec3b kRed(20, 30, 200);
const cv::Vec3b kBlue(200, 30, 20);

// A triangle with the first seeds around it.
EdgeTriangle EdgeOf(size_t seeds) {
  EdgeTriangle edge;
  for (size_t i = 0; i < seeds; ++i) edge.nearby_seeds[i] = static_cast<int>(i);
  edge.nearby_count = seeds;
  return edge;
}

PriorConfig Weights(double census, double colour) {
  PriorConfig config;
  config.set_census_weight(census);
  config.set_colour_weight(colour);
  return config;
}

// A pair in which every left pixel has one disparity, its left part red and the rest blue. Three
// seeds: one at the left border, near; two at the right one, far.
class Pair {
 public:
  Pair(cv::Size size, int disparity, int first_blue) {
    images.left_bgr = cv::Mat3b(size, kRed);
    images.left_bgr.colRange(first_blue, size.width) = kBlue;
    images.left_grey = cv::Mat1b(size);
    images.right_grey = cv::Mat1b(size, uint8_t{0});
    std::mt19937 random(1);
    for (int v = 0; v < size.height; ++v) {
      for (int u = 0; u < size.width; ++u) {
        const auto grey = static_cast<uint8_t>(random() % 256);
        images.left_grey(v, u) = grey;
        if (u >= disparity) images.right_grey(v, u - disparity) = grey;
      }
    }
    const auto right = static_cast<float>(size.width - 1);
    const auto bottom = static_cast<float>(size.height - 1);
    planes = {{.u = 0, .v = 0, .disparity = 12},
              {.u = right, .v = 0, .disparity = 3},
              {.u = right, .v = bottom, .disparity = 3}};
    Transform();
  }

  void TakeTextureAway() {
    images.left_grey = 90;
    images.right_grey = 90;
    Transform();
  }

  void Transform() {
    CensusTransform(images.left_grey, images.left_census);
    CensusTransform(images.right_grey, images.right_census);
  }

  double FarMinusNear(int u, int v, const PriorConfig& config, int near = kNearCounts,
                      int far = kFarCounts) const {
    return DataTerm(images, edges, planes, config).FarMinusNear(u, v, 0, near, far);
  }

  EdgeImages images;
  std::vector<Plane> planes;
  std::vector<EdgeTriangle> edges{EdgeOf(3)};
};

TEST(DataTerm, IsLessForTheDisparityThatTheImagesHave) {
  const cv::Size size(51, 33);
  for (const int truth : {12, 3}) {
    const Pair pair(size, truth, 20);
    for (const double census : {0.0, 1.2}) {
      const PriorConfig config = Weights(census, 0);
      for (int v = 3; v < size.height - 3; ++v) {
        for (int u = 15; u < size.width - 3; ++u) {
          EXPECT_EQ(pair.FarMinusNear(u, v, config) > 0, truth == 12) << u << ", " << v;
        }
      }
    }
  }
}

TEST(DataTerm, IsWorseByOneForGreysThatHaveNothingInCommon) {
  Pair pair({51, 33}, 3, 20);
  pair.TakeTextureAway();
  pair.images.right_grey(15, 9) = 200;  // at u = 12 of the far label, 21 of the near one
  EXPECT_NEAR(pair.FarMinusNear(21, 15, Weights(0, 0)), -1 / 9.0, 1e-9);
  EXPECT_NEAR(pair.FarMinusNear(12, 15, Weights(0, 0)), 0, 1e-9);  // leaves the image
  pair.images.right_grey = 0;
  pair.images.right_grey.colRange(20, 51) = 90;
  EXPECT_NEAR(pair.FarMinusNear(26, 15, Weights(0, 0)), -1, 1e-9);
}

TEST(DataTerm, SeesTheSameInACameraOfAnotherExposure) {
  Pair pair({51, 33}, 12, 20);
  pair.images.right_grey = pair.images.right_grey / 2 + 100;
  pair.Transform();
  for (int u = 16; u < 47; ++u) {
    EXPECT_GT(pair.FarMinusNear(u, 16, Weights(20, 0)), 0) << u;
  }
}

TEST(DataTerm, OfTheImagesIsEqualWhereAWindowLeavesThem) {
  const Pair pair({51, 33}, 3, 20);
  for (int u = 0; u < 51; ++u) {
    EXPECT_EQ(pair.FarMinusNear(u, 16, Weights(1.2, 0), 1023 * kOnePx), 0);
    EXPECT_EQ(pair.FarMinusNear(u, 2, Weights(1.2, 0)), 0);
  }
}

TEST(DataTerm, FollowsTheSeedsOfThePixelsColourWhereThereIsNoTexture) {
  Pair pair({51, 33}, 3, 40);
  pair.TakeTextureAway();
  for (int u = 0; u < 51; ++u) {
    EXPECT_EQ(pair.FarMinusNear(u, 16, Weights(1.2, 0)), 0);
    EXPECT_NEAR(pair.FarMinusNear(u, 16, Weights(1.2, 0.9)), u < 40 ? 0.9 : -0.9, 0.01);
  }
}

// Any number of seeds makes a share of 1; no seeds tell nothing.
TEST(DataTerm, CountsSharesOfSeeds) {
  Pair pair({51, 33}, 3, 51);
  pair.planes.assign(6, {.u = 5, .v = 5, .disparity = 12});
  for (const size_t seeds : {1, 3, 4, 5}) {
    pair.edges[0] = EdgeOf(seeds);
    EXPECT_NEAR(pair.FarMinusNear(1, 1, Weights(0, 1)), 1, 0.01);
    EXPECT_NEAR(pair.FarMinusNear(1, 1, Weights(0, 1), 22 * kOnePx, kNearCounts), -1, 0.01);
  }
  pair.edges[0] = EdgeOf(0);
  EXPECT_EQ(pair.FarMinusNear(1, 1, Weights(0, 1)), 0);
}

// A floor that rises towards the camera by a pixel a row, in front of a wall. Ten rows below its
// seeds it is nearer than they are.
TEST(DataTerm, ComparesTheLabelsToWhereASeedsPlaneLeads) {
  Pair pair({51, 33}, 3, 51);
  pair.planes.assign(3, {.u = 5, .v = 5, .disparity = 12, .per_row = 1});
  EXPECT_NEAR(pair.FarMinusNear(5, 15, Weights(0, 1), 22 * kOnePx, kNearCounts), 1, 0.01);
  EXPECT_NEAR(pair.FarMinusNear(5, 5, Weights(0, 1), 22 * kOnePx, kNearCounts), -1, 0.01);
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

EdgeLabels LabelsEverywhere(cv::Size size) {
  return {cv::Mat1s(size, int16_t{kNearCounts}), cv::Mat1s(size, int16_t{kFarCounts}),
          cv::Mat1i(size, 0)};
}

TEST(DataTerm, FollowsItsFormulaWithEveryInstructionSet) {
  std::mt19937 random(4);
  const auto number = [&](double scale) {
    return static_cast<float>(scale * (static_cast<double>(random() % 65536) / 65536 - 0.5));
  };
  for (const size_t count : {size_t{4}, size_t{16}, size_t{28}, size_t{32}}) {
    ColourSeeds seeds{};
    seeds.count = count;
    for (size_t i = 0; i < ColourSeeds::kMaxSeeds; ++i) {
      seeds.u[i] = number(50), seeds.v[i] = number(50), seeds.counts[i] = number(400);
      seeds.per_column[i] = number(9), seeds.per_row[i] = number(9);
      seeds.blue[i] = number(255), seeds.green[i] = number(255), seeds.red[i] = number(255);
    }
    // Beside the border, where only the colours count.
    EdgeImages images;
    images.left_bgr = cv::Mat3b(cv::Size(9, 9), cv::Vec3b(30, 20, 10));
    images.left_grey = images.right_grey = cv::Mat1b(cv::Size(9, 9), uint8_t{1});
    images.left_census = images.right_census = images.left_grey;
    const LabelledPixel pixel{.u = 1, .v = 2, .near = 45, .far = -35};
    const PriorConfig config = Weights(1, 2);
    // Eq. (P7); the labels are 5 ± 40 counts.
    double support = 0, all = 0.01;
    for (size_t i = 0; i < count; ++i) {
      const double plane = double{seeds.counts[i]} +
                           double{seeds.per_column[i]} * (1 - double{seeds.u[i]}) +
                           double{seeds.per_row[i]} * (2 - double{seeds.v[i]});
      const double colours = std::abs(30 - double{seeds.blue[i]}) +
                             std::abs(20 - double{seeds.green[i]}) +
                             std::abs(10 - double{seeds.red[i]});
      const double miss = std::min(std::abs(plane - pixel.near), std::abs(plane - pixel.far));
      const double weight = std::pow(1 + std::pow(colours / config.colour_range(), 2), -2) /
                            (1 + std::pow(miss / (kOnePx * config.edge_px()), 2));
      support += plane > 5 ? weight : -weight;
      all += weight;
    }
    std::optional<double> first;
    ForEachInstructionSet([&](const std::string& name) {
      const double term = FarMinusNear(images, seeds, DataTermScales(config), pixel);
      if (!first) first = term;
      EXPECT_EQ(term, *first) << name << ", " << count << " seeds";
      EXPECT_NEAR(term, 2 * support / all, 1e-5) << name << ", " << count << " seeds";
    });
  }
}

TEST(Decision, FindsTheEdgeToThePixelAndLeavesTheRest) {
  // Odd sizes, and some for which the first pass has hardly a pixel.
  for (const cv::Size size :
       {cv::Size(61, 43), cv::Size(62, 42), cv::Size(3, 2), cv::Size(2, 2), cv::Size(1, 1)}) {
    const int edge = size.width / 2;
    const Pair pair(size, 0, edge);
    EdgeLabels labels = LabelsEverywhere(size);
    const int without = size.height > 4 ? 0 : -1;  // row
    if (without == 0) labels.near.row(0) = DisparityImage::kInvalid;
    DisparityImage prior(cv::Mat1s(size, int16_t{7 * kOnePx}));
    const PriorConfig config = Weights(0, 100);
    DecideLabels(labels, DataTerm(pair.images, pair.edges, pair.planes, config), prior);
    for (int v = 0; v < size.height; ++v) {
      for (int u = 0; u < size.width; ++u) {
        const float expected = v == without ? 7.F : (u < edge ? 12.F : 3.F);
        ASSERT_EQ(prior.Px(u, v), expected) << u << ", " << v << " of " << size;
      }
    }
  }
}

// Pixels of even rows and columns are decided first.
TEST(Decision, GivesAPixelAmongOthersOnOneSurfaceThatOne) {
  const cv::Size size(31, 31);
  Pair pair(size, 0, size.width - 1);
  pair.images.left_bgr(15, 7) = kBlue;   // not looked at
  pair.images.left_bgr(20, 12) = kBlue;  // looked at
  DisparityImage prior(cv::Mat1s(size, int16_t{0}));
  const PriorConfig config = Weights(0, 100);
  DecideLabels(LabelsEverywhere(size), DataTerm(pair.images, pair.edges, pair.planes, config),
               prior);
  EXPECT_EQ(prior.Px(7, 15), 12);
  EXPECT_EQ(prior.Px(12, 20), 3);
}

}  // namespace
}  // namespace sprout::prior
