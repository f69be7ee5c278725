#include "common/core/image.h"

#include <gtest/gtest.h>

namespace sprout {
namespace {

TEST(ToGrey, SharesAGreyImage) {
  const cv::Mat image(3, 4, CV_8UC1, cv::Scalar(17));
  const cv::Mat1b grey = ToGrey(image);
  EXPECT_EQ(grey.data, image.data);
  EXPECT_EQ(grey(2, 3), 17);
}

TEST(ToGrey, WeighsTheChannelsInBgrOrder) {
  const cv::Mat blue(1, 1, CV_8UC3, cv::Scalar(255, 0, 0));
  const cv::Mat green(1, 1, CV_8UC3, cv::Scalar(0, 255, 0));
  const cv::Mat red(1, 1, CV_8UC3, cv::Scalar(0, 0, 255));
  // ITU-R BT.601: 0.114, 0.587 and 0.299 of 255.
  EXPECT_NEAR(ToGrey(blue)(0, 0), 29, 1);
  EXPECT_NEAR(ToGrey(green)(0, 0), 150, 1);
  EXPECT_NEAR(ToGrey(red)(0, 0), 76, 1);
}

TEST(ToGrey, KeepsTheSizeOfAViewIntoALargerImage) {
  const cv::Mat image(10, 10, CV_8UC3, cv::Scalar(50, 50, 50));
  const cv::Mat1b grey = ToGrey(image(cv::Rect(2, 3, 4, 5)));
  EXPECT_EQ(grey.size(), cv::Size(4, 5));
  EXPECT_EQ(grey(4, 3), 50);
}

TEST(Halved, HasTheMeanOfFourPixelsAndRepeatsAnOddColumnAndRow) {
  const cv::Mat1b image = (cv::Mat1b(3, 5) << 0, 4, 10, 10, 7,  //
                           8, 8, 10, 30, 9,                     //
                           20, 40, 1, 3, 200);
  const cv::Mat1b half = Halved(image);
  const cv::Mat1b expected = (cv::Mat1b(2, 3) << 5, 15, 8, 30, 2, 200);
  ASSERT_EQ(half.size(), expected.size());
  EXPECT_EQ(cv::countNonZero(half != expected), 0) << half;
}

TEST(ToBgr, SharesAColourImageAndGivesGreyThreeEqualChannels) {
  const cv::Mat colour(3, 4, CV_8UC3, cv::Scalar(1, 2, 3));
  EXPECT_EQ(ToBgr(colour).data, colour.data);
  const cv::Mat grey(4, 6, CV_8UC1, cv::Scalar(17));  // as many bytes as 4 × 2 colours
  const cv::Mat3b bgr = ToBgr(grey);
  ASSERT_EQ(bgr.size(), cv::Size(6, 4));
  EXPECT_EQ(bgr(3, 5), cv::Vec3b(17, 17, 17));
}

TEST(SizeText, PutsTheWidthFirst) { EXPECT_EQ(SizeText(cv::Size(640, 480)), "640x480"); }

}  // namespace
}  // namespace sprout
