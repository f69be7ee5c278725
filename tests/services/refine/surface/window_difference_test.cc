#include "services/refine/surface/window_difference.h"

#include <gtest/gtest.h>

#include <limits>

namespace sprout::refine {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Texture, and the same 6 px further left.
struct WindowPair {
  WindowPair() {
    cv::theRNG().state = 7;
    cv::randu(left, 0, 255);
    left.colRange(6, 40).copyTo(right.colRange(0, 34));
  }
  cv::Mat1b left = cv::Mat1b(20, 40);
  cv::Mat1b right = cv::Mat1b(20, 40, uint8_t{0});
};

TEST(WindowDifference, IsZeroAtTheDisparityAndOnePixelBesideIt) {
  const WindowPair pair;
  for (const double off : {-1.4, 0.0, 0.4, 1.4}) {
    EXPECT_EQ(WindowDifference(pair.left, pair.right, 20.3, 9.6, 14 + off), 0) << off;
  }
  EXPECT_GT(WindowDifference(pair.left, pair.right, 20, 10, 16), 0.05);
  EXPECT_GT(WindowDifference(pair.left, pair.right, 20, 10, 12), 0.05);
}

TEST(WindowDifference, IsAShareOfTheSquares) {
  const cv::Mat1b left(9, 9, uint8_t{30});
  const cv::Mat1b right(9, 9, uint8_t{10});
  EXPECT_DOUBLE_EQ(WindowDifference(left, right, 4, 4, 4), 0.4);  // 20² / (30² + 10²)
  const cv::Mat1b black(9, 9, uint8_t{0});
  EXPECT_EQ(WindowDifference(black, black, 4, 4, 4), 0);
}

TEST(WindowDifference, IsInfiniteWhereNoWindowFits) {
  const WindowPair pair;
  EXPECT_EQ(WindowDifference(pair.left, pair.right, 1.4, 10, 10), kInfinity);
  EXPECT_EQ(WindowDifference(pair.left, pair.right, 20, 17.6, 10), kInfinity);
  EXPECT_EQ(WindowDifference(pair.left, pair.right, 20, 10, 0.4), kInfinity);
  EXPECT_LT(WindowDifference(pair.left, pair.right, 20, 10, 0.6), kInfinity);  // one further fits
  EXPECT_EQ(WindowDifference(pair.left, pair.right, 20, 10, -1e30), kInfinity);
}

}  // namespace
}  // namespace sprout::refine
