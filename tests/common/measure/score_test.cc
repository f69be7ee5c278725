#include "common/measure/score.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace sprout {
namespace {

constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
const cv::Size kSize(40, 20);

cv::Mat1f ConstantTruth(float disparity_px) { return cv::Mat1f(kSize, disparity_px); }

DisparityImage ConstantMap(double disparity_px) {
  return DisparityImage(cv::Mat1s(kSize, ToCounts(disparity_px)));
}

cv::Mat1b Everywhere() { return cv::Mat1b(kSize, uchar{255}); }

TEST(Score, GivesAnAllCorrectMapOneHundred) {
  const Accuracy accuracy = Score(ConstantMap(7.25), ConstantTruth(7.25F), Everywhere()).value();
  EXPECT_EQ(accuracy.scored, kSize.area());
  EXPECT_EQ(accuracy.correct_le1_percent(), 100);
  EXPECT_EQ(accuracy.correct_lt1_percent(), 100);
  EXPECT_EQ(accuracy.density_percent(), 100);
  EXPECT_EQ(accuracy.bad2_percent(), 0);
  EXPECT_EQ(accuracy.bad4_percent(), 0);
  EXPECT_EQ(accuracy.mean_abs_px(), 0);
  EXPECT_EQ(accuracy.rms_px(), 0);
}

TEST(Score, GivesAnEmptyMapZero) {
  const Accuracy accuracy = Score(DisparityImage(kSize), ConstantTruth(7), Everywhere()).value();
  EXPECT_EQ(accuracy.correct_le1_percent(), 0);
  EXPECT_EQ(accuracy.correct_lt1_percent(), 0);
  EXPECT_EQ(accuracy.density_percent(), 0);
  EXPECT_EQ(accuracy.bad2_percent(), 100);
  EXPECT_EQ(accuracy.bad4_percent(), 100);
  EXPECT_TRUE(std::isnan(accuracy.mean_abs_px()));
  EXPECT_TRUE(std::isnan(accuracy.rms_px()));
}

TEST(Score, TellsLessOrEqualFromLessAtExactlyOnePixel) {
  // Every disparity that a count can express, off by 32 counts to either side.
  for (int counts = 0; counts < 32000; counts += 31) {
    const float truth_px = static_cast<float>(counts) / DisparityImage::kCountsPerPixel;
    for (int sign : {-1, 1}) {
      const DisparityImage off(cv::Mat1s(1, 1, static_cast<int16_t>(counts + sign * 32)));
      const Accuracy accuracy =
          Score(off, cv::Mat1f(1, 1, truth_px), cv::Mat1b(1, 1, uchar{1})).value();
      ASSERT_EQ(accuracy.correct_le1_percent(), 100) << counts;
      ASSERT_EQ(accuracy.correct_lt1_percent(), 0) << counts;
    }
  }
}

TEST(Score, SeesTheSmallestStepBeyondOnePixel) {
  // In float the difference of these would round to exactly 1.
  const float truth_px = std::nextafter(1.F, 0.F);
  const Accuracy beyond = Score(ConstantMap(2), ConstantTruth(truth_px), Everywhere()).value();
  EXPECT_EQ(beyond.correct_le1_percent(), 0);
  const Accuracy counts = Score(ConstantMap(9 + 33 / 32.0), ConstantTruth(9), Everywhere()).value();
  EXPECT_EQ(counts.correct_le1_percent(), 0);
}

TEST(Score, CountsAnErrorAsBadOnlyAboveTheThreshold) {
  const Accuracy at_2 = Score(ConstantMap(12), ConstantTruth(10), Everywhere()).value();
  EXPECT_EQ(at_2.bad2_percent(), 0);
  const Accuracy above_2 = Score(ConstantMap(12.0625), ConstantTruth(10), Everywhere()).value();
  EXPECT_EQ(above_2.bad2_percent(), 100);
  EXPECT_EQ(above_2.bad4_percent(), 0);
  const Accuracy above_4 = Score(ConstantMap(5.9375), ConstantTruth(10), Everywhere()).value();
  EXPECT_EQ(above_4.bad4_percent(), 100);
}

TEST(Score, CountsADisparityAsKittisOutlierAbove3PxAndAbove5PerCent) {
  const auto d1 = [](double map_px, float truth_px) {
    return Score(ConstantMap(map_px), ConstantTruth(truth_px), Everywhere()).value().d1_percent();
  };
  EXPECT_EQ(d1(13, 10), 0);  // 30 %, but 3 px
  EXPECT_EQ(d1(13.25, 10), 100);
  EXPECT_EQ(d1(105, 100), 0);  // 5 px, but 5 %
  EXPECT_EQ(d1(105.25, 100), 100);
  EXPECT_EQ(d1(94.75, 100), 100);
  EXPECT_EQ(Score(DisparityImage(kSize), ConstantTruth(7), Everywhere()).value().d1_percent(), 100);
}

TEST(Score, CountsGapsAsWrongButKeepsThemOutOfTheMeanError) {
  DisparityImage map = ConstantMap(13);
  map.counts().rowRange(0, 5) = ToCounts(10);               // a quarter exact
  map.counts().rowRange(5, 15) = DisparityImage::kInvalid;  // half missing
  const Accuracy accuracy = Score(map, ConstantTruth(10), Everywhere()).value();
  EXPECT_EQ(accuracy.density_percent(), 50);
  EXPECT_EQ(accuracy.correct_le1_percent(), 25);
  EXPECT_EQ(accuracy.bad2_percent(), 75);
  EXPECT_EQ(accuracy.bad4_percent(), 50);
  EXPECT_DOUBLE_EQ(accuracy.mean_abs_px(), 1.5);
  EXPECT_DOUBLE_EQ(accuracy.rms_px(), std::sqrt(4.5));
}

TEST(Score, LooksAtMaskedPixelsWithKnownTruthOnly) {
  cv::Mat1f truth = ConstantTruth(10);
  truth(0, 0) = kUnknown;
  truth(0, 1) = std::numeric_limits<float>::infinity();
  cv::Mat1b mask(kSize, uchar{0});
  mask.row(0) = 255;
  DisparityImage map = ConstantMap(10);
  map.counts().rowRange(1, kSize.height) = ToCounts(90);
  const Accuracy accuracy = Score(map, truth, mask).value();
  EXPECT_EQ(accuracy.scored, kSize.width - 2);
  EXPECT_EQ(accuracy.correct_le1_percent(), 100);
}

TEST(Score, TakesAMapInPixelsAsItIs) {
  const cv::Mat1f map(kSize, std::nextafter(11.F, 0.F));  // would round to exactly 1 px off
  const Accuracy accuracy = Score(map, ConstantTruth(10), Everywhere()).value();
  EXPECT_EQ(accuracy.correct_lt1_percent(), 100);
  for (const float none : {kUnknown, std::numeric_limits<float>::infinity()}) {
    EXPECT_EQ(Score(cv::Mat1f(kSize, none), ConstantTruth(10), Everywhere())->invalid_percent(),
              100);
  }
}

TEST(Score, HasNoFigureWithoutScoredPixels) {
  const Accuracy accuracy =
      Score(ConstantMap(10), ConstantTruth(10), cv::Mat1b(kSize, uchar{0})).value();
  EXPECT_EQ(accuracy.scored, 0);
  EXPECT_TRUE(std::isnan(accuracy.correct_le1_percent()));
  EXPECT_TRUE(std::isnan(accuracy.bad2_percent()));
}

TEST(Score, RefusesSizesThatDiffer) {
  const auto wrong_truth = Score(ConstantMap(1), cv::Mat1f(20, 41, 1.F), Everywhere());
  ASSERT_FALSE(wrong_truth.has_value());
  EXPECT_NE(wrong_truth.error().text.find("41x20"), std::string::npos) << wrong_truth.error().text;
  EXPECT_FALSE(Score(ConstantMap(1), ConstantTruth(1), cv::Mat1b(1, 1, uchar{1})).has_value());
}

/// A near square (disparity 10, columns 20 to 29) before a wall (disparity 4), as the left and as
/// the right camera see it.
cv::Mat1f SquareBeforeWall(int first_column) {
  cv::Mat1f truth(kSize, 4.F);
  truth.colRange(first_column, first_column + 10) = 10.F;
  return truth;
}

/// In the left view the wall's columns 14 to 19 lie behind the square for the right camera, and
/// columns 0 to 3 are outside its image.
cv::Mat1b ExpectedMask() {
  cv::Mat1b mask = Everywhere();
  mask.colRange(0, 4) = 0;
  mask.colRange(14, 20) = 0;
  return mask;
}

TEST(NonOccludedMask, FindsTheOcclusionBesideANearSquareFromBothViews) {
  const cv::Mat1b mask = NonOccludedMask(SquareBeforeWall(20), SquareBeforeWall(10)).value();
  EXPECT_EQ(cv::countNonZero(mask != ExpectedMask()), 0) << mask.row(0);
}

TEST(NonOccludedMask, FindsTheSameOcclusionFromTheLeftViewAlone) {
  const cv::Mat1b mask = NonOccludedMask(SquareBeforeWall(20), {}).value();
  EXPECT_EQ(cv::countNonZero(mask != ExpectedMask()), 0) << mask.row(0);
}

TEST(NonOccludedMask, LeavesOutPixelsUnknownInEitherView) {
  cv::Mat1f left = ConstantTruth(4);
  cv::Mat1f right = ConstantTruth(4);
  left(3, 30) = kUnknown;
  left(4, 30) = std::numeric_limits<float>::infinity();
  right(5, 20) = kUnknown;
  const cv::Mat1b both = NonOccludedMask(left, right).value();
  EXPECT_EQ(both(3, 30), 0);
  EXPECT_EQ(both(4, 30), 0);
  EXPECT_EQ(both(5, 24), 0);
  EXPECT_EQ(cv::countNonZero(both), (kSize.width - 4) * kSize.height - 3);
  const cv::Mat1b alone = NonOccludedMask(left, {}).value();
  EXPECT_EQ(alone(3, 30), 0);
  EXPECT_EQ(cv::countNonZero(alone), (kSize.width - 4) * kSize.height - 2);
}

TEST(NonOccludedMask, AllowsViewsToDifferByExactlyOnePixel) {
  const cv::Mat1f left = ConstantTruth(4);
  EXPECT_EQ(NonOccludedMask(left, ConstantTruth(5)).value()(0, 20), 255);
  EXPECT_EQ(NonOccludedMask(left, ConstantTruth(std::nextafter(5.F, 6.F))).value()(0, 20), 0);
}

TEST(NonOccludedMask, ReadsTheRightViewAtTheRoundedColumn) {
  for (float disparity_px : {2.6F, 3.4F}) {  // 20 − 2.6 = 17.4, 20 − 3.4 = 16.6
    cv::Mat1f right(kSize, kUnknown);
    right.col(17) = disparity_px;
    const cv::Mat1b mask = NonOccludedMask(ConstantTruth(disparity_px), right).value();
    EXPECT_EQ(mask(0, 20), 255) << disparity_px;
    EXPECT_EQ(cv::countNonZero(mask), kSize.height) << disparity_px;
  }
}

TEST(NonOccludedMask, KeepsPixelsOfOneSlantedSurfaceThatShareARightColumn) {
  cv::Mat1f slant(kSize);
  for (int u = 0; u < kSize.width; ++u) slant.col(u) = 2.F + 0.9F * static_cast<float>(u) / 2;
  EXPECT_EQ(NonOccludedMask(slant, {}).value()(0, 20), 255);
  EXPECT_EQ(NonOccludedMask(slant, {}).value()(0, 21), 255);
}

TEST(OccludedMask, HoldsWhatANearerSurfaceHidesButNotWhatIsOutside) {
  cv::Mat1b expected(kSize, uchar{0});
  expected.colRange(14, 20) = 255;
  const cv::Mat1b both = OccludedMask(SquareBeforeWall(20), SquareBeforeWall(10)).value();
  EXPECT_EQ(cv::countNonZero(both != expected), 0) << both.row(0);
  const cv::Mat1b alone = OccludedMask(SquareBeforeWall(20), {}).value();
  EXPECT_EQ(cv::countNonZero(alone != expected), 0) << alone.row(0);
}

TEST(OccludedMask, LeavesOutPixelsUnknownInEitherView) {
  cv::Mat1f left = SquareBeforeWall(20);
  cv::Mat1f right = SquareBeforeWall(10);
  left(3, 15) = kUnknown;
  right(4, 11) = kUnknown;  // where the left pixel 15 would be
  const cv::Mat1b mask = OccludedMask(left, right).value();
  EXPECT_EQ(mask(3, 15), 0);
  EXPECT_EQ(mask(4, 15), 0);
  EXPECT_EQ(mask(5, 15), 255);
}

TEST(OccludedMask, RefusesViewsOfDifferentSize) {
  EXPECT_FALSE(OccludedMask(ConstantTruth(4), cv::Mat1f(3, 3, 4.F)).has_value());
}

TEST(NonOccludedMask, RefusesViewsOfDifferentSize) {
  EXPECT_FALSE(NonOccludedMask(ConstantTruth(4), cv::Mat1f(3, 3, 4.F)).has_value());
}

}  // namespace
}  // namespace sprout
