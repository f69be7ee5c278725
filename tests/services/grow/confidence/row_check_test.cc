#include "services/grow/confidence/row_check.h"

#include <gmock/gmock.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "common/core/prior_map.h"

namespace sprout::grow {
namespace {

const cv::Size kWallSize(480, 360);
constexpr int kWallPx = 20;

cv::Mat1b RandomImage(int seed) {
  cv::Mat1b image(kWallSize);
  cv::RNG(static_cast<uint64_t>(seed)).fill(image, cv::RNG::UNIFORM, 0, 256);
  cv::GaussianBlur(image, image, {}, 1.5);
  cv::normalize(image, image, 0, 255, cv::NORM_MINMAX);
  return image;
}

// A wall whose map is right, and claims so.
struct Wall {
  cv::Mat1b left = RandomImage(1);
  cv::Mat1b right{kWallSize};
  DisparityImage map{cv::Mat1s(kWallSize, ToCounts(kWallPx))};
  std::vector<Seed> seeds;
  cv::Mat1b sigma_prior;

  Wall() { Turn(0, 1); }
  // Another right camera.
  void Turn(double degrees, double scale, double rows = 0) {
    cv::Mat1d moved = cv::getRotationMatrix2D(cv::Point2f(kWallSize) / 2, degrees, scale);
    moved(0, 2) -= kWallPx;
    moved(1, 2) += rows;
    cv::warpAffine(left, right, moved, kWallSize, cv::INTER_LINEAR, cv::BORDER_REFLECT);
  }
  ConfidenceEstimator::Judgement Claimed() const {
    return {cv::Mat1b(kWallSize, uint8_t{200}), cv::Mat1b(kWallSize, uint8_t{4})};
  }
  JudgedFrame Frame() const { return {left, right, seeds, sigma_prior, map, map}; }
  RowCheck Check() const { return CheckRows(Frame(), Claimed().confidence, SeedOrigin::kStereo); }
  // Range points every 10 px, from a column on, where the map has them.
  void AddRanges(int from) {
    for (int v = 0; v < kWallSize.height; v += 10) {
      for (int u = from; u < kWallSize.width; u += 10) {
        const auto column = static_cast<float>(u);
        const auto row = static_cast<float>(v);
        seeds.push_back({.u = column, .v = row, .u_right = column - map.Px(u, v)});
      }
    }
  }
};

TEST(RowCheck, SaysNothingOfAMapThatIsRight) {
  const Wall wall;
  EXPECT_EQ(wall.Check().columns_px, 0);
  EXPECT_GT(wall.Check().right_share, 0.99);
  EXPECT_NEAR(wall.Check().claimed, 200 / 255.0, 1e-6);
  auto judged = wall.Claimed();
  EXPECT_EQ(BoundByRows(wall.Frame(), judged), "");
  EXPECT_EQ(cv::countNonZero(judged.confidence == 200), kWallSize.area());
}

TEST(RowCheck, FindsColumnsThatAreOffAsRowsAre) {
  Wall wall;
  wall.Turn(0.8, 1);  // rows by 0.014 of 180 px in the outermost of 4×3 cells
  EXPECT_NEAR(wall.Check().columns_px, 2.5, 0.3);
  wall.Turn(0, 1.012);  // columns by 0.012 of these
  EXPECT_NEAR(wall.Check().columns_px, 2.2, 0.3);
  wall.Turn(0, 1, 3);  // no columns, but growth on wrong rows
  EXPECT_NEAR(wall.Check().columns_px, 1.5, 0.2);
  wall.Turn(0.1, 1);
  EXPECT_EQ(wall.Check().columns_px, 0);
}

TEST(RowCheck, BoundsConfidenceByThem) {
  Wall wall;
  wall.Turn(0, 1, 4);
  const double columns_px = wall.Check().columns_px;
  auto judged = wall.Claimed();
  EXPECT_THAT(BoundByRows(wall.Frame(), judged), testing::HasSubstr("may be off by 2.0 px"));
  EXPECT_EQ(judged.confidence(100, 100), static_cast<int>(200 / columns_px));
  EXPECT_EQ(judged.sigma(100, 100), SigmaToCounts(std::hypot(0.25, columns_px / std::sqrt(3))));
}

// Half of the map is 7 px off.
TEST(RowCheck, FindsTheShareThatIsRight) {
  Wall wall;
  wall.map.counts().colRange(0, kWallSize.width / 2) = ToCounts(kWallPx + 7);
  const RowCheck check = wall.Check();
  EXPECT_NEAR(check.right_share, 0.5 + 3 * 0.5 / std::sqrt(280) / 0.6, 0.12);
  auto judged = wall.Claimed();
  EXPECT_THAT(BoundByRows(wall.Frame(), judged), testing::HasSubstr("78 % are claimed"));
  EXPECT_NEAR(judged.confidence(100, 300), 255 * check.right_share / 0.8, 2);
  EXPECT_EQ(judged.sigma(100, 300), 4);
}

TEST(RowCheck, BelievesNothingOfAnotherScene) {
  Wall wall;
  wall.right = RandomImage(2);
  auto judged = wall.Claimed();
  BoundByRows(wall.Frame(), judged);
  EXPECT_LT(judged.confidence(100, 100), 0.25 * 255);
}

// Ranges of another scene beside a pair that does not fit, so that nothing else finds them wrong.
TEST(RowCheck, BelievesNoRangesThatTheImagesShowNowhere) {
  Wall wall;
  wall.map.counts().colRange(kWallSize.width / 2, kWallSize.width) = ToCounts(kWallPx + 7);
  wall.AddRanges(kWallSize.width / 2);
  wall.Turn(0.8, 1);
  auto judged = wall.Claimed();
  EXPECT_THAT(BoundByRows(wall.Frame(), judged), testing::HasSubstr("depends on ranges"));
  EXPECT_LT(judged.confidence(100, 400), 0.3 * 255);
}

TEST(RowCheck, BelievesRangesThatTheImagesShowOnOtherRows) {
  Wall wall;
  wall.AddRanges(0);
  wall.Turn(0.8, 1, 3);
  auto judged = wall.Claimed();
  EXPECT_EQ(BoundByRows(wall.Frame(), judged), "");
  EXPECT_EQ(judged.confidence(100, 300), 200);
}

// The right camera has another moment of the same noise, so that hardly any corner matches.
TEST(RowCheck, LeavesRangesWhereNoiseIsAllThatImagesShow) {
  Wall wall;
  wall.AddRanges(0);
  for (cv::Mat1b* image : {&wall.left, &wall.right}) {
    cv::RNG(image == &wall.left ? 1 : 2).fill(*image, cv::RNG::NORMAL, 128, 20);
  }
  auto judged = wall.Claimed();
  EXPECT_EQ(BoundByRows(wall.Frame(), judged), "");
}

TEST(RowCheck, LeavesRangesWhereImagesShowNothing) {
  Wall wall;
  wall.right = RandomImage(2);
  wall.left.colRange(kWallSize.width / 2, kWallSize.width) = uint8_t{128};
  wall.AddRanges(kWallSize.width / 2);
  auto judged = wall.Claimed();
  EXPECT_NE(BoundByRows(wall.Frame(), judged), "");
  EXPECT_LT(judged.confidence(100, 100), 0.25 * 255);
  EXPECT_EQ(judged.confidence(100, 300), 200);
}

TEST(RowCheck, SaysNothingWithoutTexture) {
  Wall wall;
  wall.left = uint8_t{128};
  wall.right = uint8_t{128};
  auto judged = wall.Claimed();
  EXPECT_EQ(BoundByRows(wall.Frame(), judged), "");
}

}  // namespace
}  // namespace sprout::grow
