#include "common/core/median.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

namespace sprout {
namespace {

TEST(MedianFilter, EqualsOpenCvsWhateverTheHeight) {
  MedianFilter median;
  for (const int height : {1, 2, 63, 64, 65, 200}) {
    cv::Mat1s image(height, 37);
    cv::randu(image, -1000, 1000);
    cv::Mat1s expected;
    cv::medianBlur(image, expected, 5);
    cv::Mat1s medians(image.size());
    median.Apply(image, medians);
    EXPECT_EQ(cv::countNonZero(medians != expected), 0) << height;
  }
}

}  // namespace
}  // namespace sprout
