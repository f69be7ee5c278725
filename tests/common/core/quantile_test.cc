#include "common/core/quantile.h"

#include <gtest/gtest.h>

#include <array>
#include <opencv2/imgproc.hpp>
#include <span>
#include <vector>

#include "common/core/median.h"

namespace sprout {
namespace {

TEST(Median, IsTheValueInTheMiddleAndOfTwoTheUpper) {
  EXPECT_EQ(Median(std::vector{7}), 7);
  EXPECT_EQ(Median(std::vector{9, 1, 5}), 5);
  EXPECT_EQ(Median(std::vector{4, 2, 8, 6}), 6);
  EXPECT_EQ(Median(std::vector{0.5F, 0.25F}), 0.5F);
}

TEST(Quantile, HasTheShareOfTheValuesBelowIt) {
  // 100 to 1, 1 to 100 when sorted: ⌊share · 100⌋ of them are below.
  const auto quantile = [](double share) {
    std::vector<int> values;
    for (int i = 100; i > 0; --i) values.push_back(i);
    return Quantile(values, share);
  };
  EXPECT_EQ(quantile(0), 1);
  EXPECT_EQ(quantile(0.1), 11);
  EXPECT_EQ(quantile(0.2), 21);
  EXPECT_EQ(quantile(0.5), 51);
  EXPECT_EQ(quantile(0.75), 76);
  EXPECT_EQ(quantile(0.999), 100);
}

TEST(Quantile, OfOneHalfIsTheMedian) {
  for (int count = 1; count < 20; ++count) {
    std::vector<int> values;
    for (int i = 0; i < count; ++i) values.push_back(i * 7 % count);
    EXPECT_EQ(Quantile(std::vector(values), 0.5), Median(std::vector(values))) << count;
  }
}

TEST(OrderStatistic, IsTheValueOfARankAmongThoseThatItIsGiven) {
  std::array<int, 6> values = {3, 1, 2, 0, 0, 0};
  const std::span first_three = std::span(values).first(3);
  EXPECT_EQ(OrderStatistic(first_three, 0), 1);
  EXPECT_EQ(OrderStatistic(first_three, 1), 2);
  EXPECT_EQ(OrderStatistic(first_three, 2), 3);
  EXPECT_EQ(OrderStatistic(std::vector{5, 5, 1}, 1), 5);
}

TEST(FilterByMedian, EqualsOpenCvsWhateverTheSize) {
  for (const cv::Size size : {cv::Size(37, 1), {1, 7}, {5, 63}, {37, 2}, {64, 65}, {301, 200}}) {
    cv::Mat1s image(size);
    cv::randu(image, size.width % 2 == 0 ? -3 : INT16_MIN, size.width % 2 == 0 ? 3 : INT16_MAX);
    cv::Mat1s expected;
    cv::medianBlur(image, expected, 5);
    cv::Mat1s medians(size);
    FilterByMedian(image, medians);
    EXPECT_EQ(cv::countNonZero(medians != expected), 0) << size;
  }
}

}  // namespace

}  // namespace sprout
