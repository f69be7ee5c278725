#include "common/measure/sparsification.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sprout {
namespace {

// 100 pixels in a row whose true disparity is 5; the last `wrong` ones are 3 px off.
struct Row {
  cv::Mat1f map = cv::Mat1f(1, 100, 5.F);
  cv::Mat1f truth = cv::Mat1f(1, 100, 5.F);
  cv::Mat1b mask = cv::Mat1b(1, 100, uchar{255});

  explicit Row(int wrong) { map.colRange(100 - wrong, 100) = 8.F; }
  Sparsification With(const cv::Mat1b& confidence) const {
    return Sparsify(map, truth, mask, confidence);
  }
};

cv::Mat1b Descending() {
  cv::Mat1b confidence(1, 100);
  for (int u = 0; u < 100; ++u) confidence(0, u) = static_cast<uchar>(200 - u);
  return confidence;
}

TEST(Sparsify, GivesAPerfectConfidenceTheOraclesArea) {
  const Sparsification curve = Row(10).With(Descending());
  EXPECT_DOUBLE_EQ(curve.BestPercent(100), 10);
  EXPECT_DOUBLE_EQ(curve.BestPercent(95), 100 * 5 / 95.0);
  EXPECT_DOUBLE_EQ(curve.BestPercent(90), 0);
  EXPECT_DOUBLE_EQ(curve.BestPercent(5), 0);
  EXPECT_GT(curve.area_percent, 0);
  EXPECT_DOUBLE_EQ(curve.area_percent, curve.oracle_area_percent);
}

TEST(Sparsify, SeesAConfidenceThatIsUpsideDown) {
  const Sparsification curve = Row(10).With(cv::Mat1b(255 - Descending()));
  EXPECT_DOUBLE_EQ(curve.BestPercent(5), 100);
  EXPECT_DOUBLE_EQ(curve.BestPercent(20), 50);
  EXPECT_DOUBLE_EQ(curve.BestPercent(100), 10);
}

TEST(Sparsify, TakesOneConfidenceForAllAsNoKnowledge) {
  const Sparsification curve = Row(10).With(cv::Mat1b(1, 100, uchar{7}));
  for (const double bad1 : curve.bad1_percent) EXPECT_DOUBLE_EQ(bad1, 10);
  EXPECT_NEAR(curve.area_percent, 10, 1e-9);
}

TEST(Sparsify, CountsAMissingDisparityAsWrongAndSkipsWhatIsNotScored) {
  Row row(0);
  row.map.colRange(0, 10) = NAN;
  row.mask.colRange(50, 100) = 0;
  row.truth(0, 49) = NAN;
  EXPECT_DOUBLE_EQ(row.With(Descending()).BestPercent(100), 100 * 10 / 49.0);
}

TEST(Sparsify, HasNothingToSayOfNoPixels) {
  Row row(0);
  row.mask = 0;
  EXPECT_TRUE(std::isnan(row.With(Descending()).BestPercent(100)));
}

}  // namespace
}  // namespace sprout
