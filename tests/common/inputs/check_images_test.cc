#include <gmock/gmock.h>

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>

#include "tests/common/inputs/parts.h"

namespace sprout::inputs {
namespace {

// The image as it looks `columns` px further right, repeated at the border.
cv::Mat1b Aside(const cv::Mat1b& image, double columns) {
  cv::Mat1b moved;
  cv::warpAffine(image, moved, cv::Matx23d(1, 0, columns, 0, 1, 0), image.size(), cv::INTER_NEAREST,
                 cv::BORDER_REFLECT);
  return moved;
}

TEST(CheckImages, SaysThatAnImageHasFieldsOfTwoMoments) {
  for (const bool in_right : {false, true}) {
    Parts parts = SceneOf();
    cv::Mat1b& image = in_right ? parts.right : parts.left;
    const cv::Mat1b moved = Aside(image, 8);
    for (int y = 1; y < image.rows; y += 2) moved.row(y).copyTo(image.row(y));
    ExpectBad(parts, Question::kBits, in_right ? "rows of the right" : "rows of the left");
    ExpectBad(parts, Question::kBits, "interlaced");
  }
}

TEST(CheckImages, SaysWhereAnImageIsTorn) {
  for (const int columns : {-40, 12}) {
    Parts parts = SceneOf();
    const cv::Mat1b moved = Aside(parts.right, columns);
    moved.rowRange(200, moved.rows).copyTo(parts.right.rowRange(200, moved.rows));
    ExpectBad(parts, Question::kBits,
              "from row 200 on it goes on " + std::to_string(std::abs(columns)) + " px further " +
                  (columns > 0 ? "right" : "left"));
  }
}

// No corner of one image is in the other any more.
TEST(CheckImages, SaysWhichImageIsTooBlurredToShowCorners) {
  for (const bool in_right : {false, true}) {
    Parts parts = SceneOf();
    cv::Mat1b& image = in_right ? parts.right : parts.left;
    cv::GaussianBlur(image, image, {}, 10);
    ASSERT_EQ(parts.Answer(Question::kScene).verdict, Verdict::kCannotTell);
    ExpectBad(parts, Question::kContrast, in_right ? "right image is blurred" : "left image is");
  }
  Parts parts = SceneOf();
  for (cv::Mat1b* image : {&parts.left, &parts.right}) cv::GaussianBlur(*image, *image, {}, 10);
  EXPECT_NE(parts.Answer(Question::kContrast).verdict, Verdict::kBad);
}

TEST(CheckImages, SaysThatOneImageIsDarkerWhereBothHaveOneContrast) {
  for (const double share : {0.9, 0.7}) {
    Parts parts = SceneOf();
    const double brightness = cv::mean(parts.right)[0];
    parts.right -= (1 - share) * brightness;
    const Finding finding = parts.Answer(Question::kContrast);
    EXPECT_EQ(finding.verdict, share < 0.8 ? Verdict::kBad : Verdict::kGood) << finding.text;
    if (share < 0.8) {
      EXPECT_NEAR(finding.value, share, 0.05);
      EXPECT_THAT(finding.text, testing::HasSubstr("times as bright in the right one: give both"));
    }
  }
}

// Rows of other squares, and one thing before a blank wall, are no tears.
TEST(CheckImages, TakesPatternsAndEdgesForWhole) {
  Parts parts = SceneOf();
  for (cv::Mat1b* image : {&parts.left, &parts.right}) {
    cv::RNG(1).fill(*image, cv::RNG::NORMAL, 100, 3);
    for (int y = 0; y < image->rows; ++y) {
      for (int x = 0; x < image->cols; ++x) {
        if ((x / 40 + y / 40) % 2 == 0) (*image)(y, x) += 80;
      }
    }
  }
  EXPECT_EQ(parts.Answer(Question::kBits).verdict, Verdict::kGood);
  for (cv::Mat1b* image : {&parts.left, &parts.right}) {
    cv::RNG(1).fill(*image, cv::RNG::NORMAL, 100, 3);
    (*image)(cv::Rect(200, 100, 60, 200)) += 100;
    (*image)(cv::Rect(260, 300, 60, 180)) += 100;
  }
  EXPECT_EQ(parts.Answer(Question::kBits).verdict, Verdict::kGood);
}

}  // namespace
}  // namespace sprout::inputs
