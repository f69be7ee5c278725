#include "common/scenes/same_picture.h"

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "common/core/image.h"

namespace sprout::scenes {
namespace {

TEST(IsSamePicture, BearsLossButNoOtherPicture) {
  cv::Mat3b picture(60, 80);
  cv::randu(picture, 0, 256);
  cv::GaussianBlur(picture, picture, {9, 9}, 0);
  std::vector<uchar> jpeg;
  cv::imencode(".jpg", picture, jpeg, {cv::IMWRITE_JPEG_QUALITY, 30});
  EXPECT_TRUE(IsSamePicture(picture, cv::imdecode(jpeg, cv::IMREAD_COLOR)));
  EXPECT_TRUE(IsSamePicture(picture, ToGrey(picture)));
  cv::Mat3b flipped;
  cv::flip(picture, flipped, 1);
  EXPECT_FALSE(IsSamePicture(picture, flipped));
  EXPECT_FALSE(IsSamePicture(picture, picture(cv::Rect(0, 0, 79, 60))));
}

TEST(IsSamePicture, KnowsImagesWithoutContrastByTheirBrightness) {
  const cv::Mat1b grey(60, 80, uchar{90});
  EXPECT_TRUE(IsSamePicture(grey, cv::Mat1b(grey + 2)));
  EXPECT_FALSE(IsSamePicture(grey, cv::Mat1b(grey + 20)));
}

}  // namespace
}  // namespace sprout::scenes
