#include "services/depth/preview.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "common/picture/color_map.h"
#include "tests/common/core/centred.h"

namespace sprout::depth {
namespace {

RectifiedPair PairOf(cv::Size size) { return CentredPair(size.width, size.height, 500); }

// Far on the left, near on the right.
DisparityImage TwoPlanes(cv::Size size) {
  DisparityImage map(cv::Mat1s(size, ToCounts(10)));
  map.counts()(cv::Rect(size.width / 2, 0, size.width - size.width / 2, size.height)) =
      ToCounts(50);
  return map;
}

int64_t CountColor(const cv::Mat3b& picture, const cv::Vec3b& color) {
  cv::Mat1b mask;
  cv::inRange(picture, color, color, mask);
  return cv::countNonZero(mask);
}

cv::Vec3b FarColor() { return ColorOf(0, {0, 1}); }
cv::Vec3b NearColor() { return ColorOf(1, {0, 1}); }
const cv::Vec3b kLeftColor{40, 200, 90};

cv::Mat3b Preview(cv::Size size) {
  return PreviewOf(cv::Mat(size, CV_8UC3, cv::Scalar(kLeftColor)), TwoPlanes(size), PairOf(size));
}

TEST(Preview, HasTheLeftImageAndDepthInColoursSideBySide) {
  const cv::Size size(64, 48);
  const cv::Mat3b picture = Preview(size);
  const cv::Rect left_half(0, 0, picture.cols / 3, picture.rows);
  EXPECT_EQ(CountColor(picture, kLeftColor), size.area());
  EXPECT_GT(CountColor(picture(left_half), kLeftColor), 0);
  EXPECT_EQ(CountColor(picture(left_half), NearColor()), 0);
  // At least so many pixels, some of them in the scale.
  EXPECT_GE(CountColor(picture, NearColor()), size.area() / 2);
  EXPECT_GE(CountColor(picture, FarColor()), size.area() / 2);
}

TEST(Preview, TakesImagesInGrey) {
  const cv::Size size(64, 48);
  const cv::Mat3b picture =
      PreviewOf(cv::Mat(size, CV_8UC1, cv::Scalar(77)), TwoPlanes(size), PairOf(size));
  EXPECT_GE(CountColor(picture, {77, 77, 77}), size.area());
}

TEST(Preview, IsMadeSmallerByAWholeNumber) {
  const cv::Size whole(1503, 1000);  // by 3, and nothing left over but a row
  EXPECT_EQ(CountColor(Preview(whole), kLeftColor), 501 * 333);
  const cv::Size just_fits(640, 100);
  EXPECT_EQ(CountColor(Preview(just_fits), kLeftColor), just_fits.area());
  const cv::Size too_high(100, 641);
  EXPECT_EQ(CountColor(Preview(too_high), kLeftColor), 50 * 320);
}

TEST(Preview, OfASliverHasAPixelOfIt) {
  EXPECT_EQ(CountColor(Preview({2000, 1}), kLeftColor), 500);
  EXPECT_EQ(CountColor(Preview({1, 1}), kLeftColor), 1);
}

TEST(Preview, OfAMapWithoutDisparitiesIsDark) {
  const cv::Size size(64, 48);
  const cv::Mat3b picture =
      PreviewOf(cv::Mat(size, CV_8UC3, cv::Scalar(kLeftColor)), DisparityImage(size), PairOf(size));
  EXPECT_GE(CountColor(picture, kNoValueColor), size.area());
}

}  // namespace
}  // namespace sprout::depth
