#include "services/prior/sigma_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "common/core/prior_map.h"

namespace sprout {
namespace {

constexpr int kSide = 40;

// Two triangles that make a square of kSide px with its corners on whole pixels.
struct Square {
  std::vector<LocalPlane> planes{{.u = 0, .v = 0, .disparity = 10, .sigma_px = 0.5F},
                                 {.u = kSide, .v = 0, .disparity = 10, .sigma_px = 0.5F},
                                 {.u = 0, .v = kSide, .disparity = 10, .sigma_px = 0.5F},
                                 {.u = kSide, .v = kSide, .disparity = 10, .sigma_px = 0.5F}};
  std::vector<SeedTriangle> triangles{{0, 1, 2}, {1, 3, 2}};

  cv::Mat1b Paint() const {
    cv::Mat1b sigma;
    PaintSigma(planes, triangles, cv::Size(60, 60), sigma);
    return sigma;
  }
};

TEST(SigmaMap, IsThatOfSeedsThatAgree) {
  Square square;
  EXPECT_EQ(square.Paint()(20, 20), SigmaToCounts(0.5));
  for (LocalPlane& plane : square.planes) {  // one slant
    plane.per_column = 0.25F;
    plane.disparity += 0.25F * plane.u;
  }
  EXPECT_EQ(square.Paint()(10, 10), SigmaToCounts(0.5));
}

TEST(SigmaMap, TakesTheMeanVarianceOfTheCorners) {
  Square square;
  square.planes[0].sigma_px = 3;
  const cv::Mat1b sigma = square.Paint();
  EXPECT_EQ(sigma(5, 5), SigmaToCounts(std::sqrt((9 + 0.25 + 0.25) / 3)));
  EXPECT_EQ(sigma(35, 35), SigmaToCounts(0.5));
}

TEST(SigmaMap, GrowsWherePlanesDoNotLeadIntoEachOther) {
  Square square;
  square.planes[0].per_column = 0.06F;  // 0.8 px off at the centroid, 40/3 px away
  EXPECT_EQ(square.Paint()(5, 5), SigmaToCounts(std::sqrt((3 * 0.25 + 0.64) / 3)));
}

TEST(SigmaMap, DoesNotCountTheStepOfADepthEdge) {
  Square square;
  square.planes[0].disparity = 50;
  EXPECT_EQ(square.Paint()(5, 5), SigmaToCounts(0.5));
}

TEST(SigmaMap, KnowsNothingOutsideTheTriangles) {
  const cv::Mat1b sigma = Square().Paint();
  EXPECT_EQ(sigma(50, 20), kMaxSigmaCounts);
  EXPECT_EQ(sigma(20, 50), kMaxSigmaCounts);
}

}  // namespace
}  // namespace sprout
