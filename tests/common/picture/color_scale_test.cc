#include "common/picture/color_scale.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <limits>

#include "common/picture/text.h"

namespace sprout {
namespace {

using ::testing::ElementsAre;

std::vector<std::string> Labels(const ValueRange& range, int max_count) {
  std::vector<std::string> labels;
  for (const Tick& tick : RoundTicks(range, max_count)) labels.push_back(tick.label);
  return labels;
}

TEST(RoundTicks, LieAtRoundValuesInsideTheRange) {
  EXPECT_THAT(Labels({45, 150}, 9), ElementsAre("60", "80", "100", "120", "140"));
  EXPECT_THAT(Labels({0, 1}, 6), ElementsAre("0.0", "0.2", "0.4", "0.6", "0.8", "1.0"));
  EXPECT_THAT(Labels({-10, 10}, 5), ElementsAre("-10", "-5", "0", "5", "10"));
}

TEST(RoundTicks, ShowAsManyDecimalsAsTheirStepNeeds) {
  EXPECT_THAT(Labels({1.0, 1.1}, 3), ElementsAre("1.00", "1.05", "1.10"));
}

TEST(RoundTicks, AreNeverMoreThanAskedFor) {
  for (int max_count = 2; max_count < 12; ++max_count) {
    for (double max = 0.11; max < 1000; max *= 1.07) {
      const size_t count = RoundTicks({0.1, max}, max_count).size();
      EXPECT_LE(count, static_cast<size_t>(max_count)) << "up to " << max;
    }
  }
}

TEST(RoundDepthTicks, LieAtRoundDepthsFarEnoughApart) {
  for (const ValueRange& range :
       {ValueRange{0.8, 8}, ValueRange{1.01, 1.02}, ValueRange{0.001, 10'000},
        ValueRange{2, std::numeric_limits<double>::infinity()}}) {
    const std::vector<Tick> ticks = RoundDepthTicks(range, 0.1);
    EXPECT_GE(ticks.size(), 3U) << range.min << " to " << range.max;
    EXPECT_LE(ticks.size(), 9U);
    double last_share = 1;
    for (const Tick& tick : ticks) {
      const double share = ShareOfDepth(tick.value, range);
      EXPECT_LE(share, last_share - 0.1 + 1e-9) << tick.label;
      EXPECT_NEAR(std::stod(tick.label), tick.value, 1e-9);
      last_share = share;
    }
  }
}

class ColorScalePicture : public ::testing::Test {
 protected:
  static constexpr int kTop = 30;
  static constexpr int kCapHeight = 9;

  static cv::Mat3b Draw(const ScaleContent& content, int height) {
    const ColorScale scale(content, height, kCapHeight);
    cv::Mat3b picture(kTop + height + 20, 20 + scale.width(), cv::Vec3b::all(255));
    scale.Draw(picture, {10, kTop}, kTop - kCapHeight);
    return picture;
  }

  // Whether anything is written in a part of a picture.
  static bool HasInk(const cv::Mat3b& part) {
    return std::any_of(part.begin(), part.end(), [](const cv::Vec3b& pixel) {
      return pixel[0] < 128 && pixel == cv::Vec3b::all(pixel[0]);
    });
  }

  const ScaleContent content_{.axes = {{{0, 100}, "px"}}};
};

TEST_F(ColorScalePicture, HasTheLargestValueOnTop) {
  const cv::Mat3b picture = Draw(content_, 200);
  EXPECT_EQ(picture(30, 12), ColorOf(100, {0, 100}));
  EXPECT_EQ(picture(229, 12), ColorOf(0, {0, 100}));
  EXPECT_EQ(picture(230, 12), cv::Vec3b::all(255)) << "bar is longer than asked for";
}

TEST_F(ColorScalePicture, HasNumbersAtBothEndsAtAnySizeAndForAnyRange) {
  for (const ValueRange& range :
       {ValueRange{6, 9}, ValueRange{0, 1e20}, ValueRange{-0.001, 0.002}}) {
    for (const int height : {ColorScale::MinHeight(kCapHeight), 60, 500}) {
      for (const bool is_depth : {false, true}) {
        if (is_depth && range.min <= 0) continue;
        const cv::Mat3b picture = Draw({.axes = {{range, "", is_depth}}}, height);
        const int numbers = 10 + 3 * kCapHeight / 2 + kCapHeight;
        EXPECT_TRUE(HasInk(picture(cv::Rect(numbers, kTop - 5, picture.cols - numbers, 10))));
        EXPECT_TRUE(
            HasInk(picture(cv::Rect(numbers, kTop + height - 5, picture.cols - numbers, 10))));
      }
    }
  }
}

TEST_F(ColorScalePicture, MarksTheEndsThatValuesLieBeyond) {
  ScaleContent clipped = content_;
  clipped.above = true;
  EXPECT_EQ(Draw(content_, 200)(kTop - 2, 16), cv::Vec3b::all(255));
  EXPECT_EQ(Draw(clipped, 200)(kTop - 2, 16), ColorOf(100, {0, 100}));
  EXPECT_EQ(Draw(clipped, 200)(kTop + 201, 16), cv::Vec3b::all(255));
  clipped.below = true;
  EXPECT_EQ(Draw(clipped, 200)(kTop + 201, 16), ColorOf(0, {0, 100}));
  EXPECT_GT(ColorScale(clipped, 200, 9).width(), ColorScale(content_, 200, 9).width()) << "> and <";
}

TEST_F(ColorScalePicture, HasASecondColumnToTheLeft) {
  ScaleContent two = content_;
  two.axes.push_back({{0.5, 5}, "m", /*is_depth=*/true});
  const int more = ColorScale(two, 200, 9).width() - ColorScale(content_, 200, 9).width();
  ASSERT_GT(more, 9);
  EXPECT_TRUE(HasInk(Draw(two, 200)(cv::Rect(10, kTop, more, 200))));
}

TEST(Text, GrowsWithItsHeightAndStaysInsideItsWidth) {
  EXPECT_GT(TextWidth("disparity", 20), TextWidth("disparity", 10));
  const int width = TextWidth("disparity", 20);
  cv::Mat3b picture(60, width + 20, cv::Vec3b::all(255));
  DrawText(picture, "disparity", {10, 40}, 20, {0, 0, 0});
  EXPECT_LT(cv::mean(picture)[0], 250) << "nothing was written";
  EXPECT_EQ(cv::mean(picture.colRange(0, 8)), cv::Scalar(255, 255, 255));
  EXPECT_EQ(cv::mean(picture.colRange(width + 12, width + 20)), cv::Scalar(255, 255, 255));
}

TEST(Text, IsCutOffAtTheEdgeOfThePicture) {
  cv::Mat3b picture(12, 20, cv::Vec3b::all(255));
  DrawText(picture, "wider than the picture", {-5, 10}, 12, {0, 0, 0});
  EXPECT_LT(cv::mean(picture)[0], 250);
}

}  // namespace
}  // namespace sprout
