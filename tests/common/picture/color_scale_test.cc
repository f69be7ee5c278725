#include "common/picture/color_scale.h"

#include <gmock/gmock.h>

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

TEST(ColorScale, HasTheLargestValueOnTop) {
  const ValueRange range{0, 100};
  const ColorScale scale(range, "px", 200, 9);
  cv::Mat3b picture(240, 20 + scale.width(), cv::Vec3b::all(255));
  scale.Draw(picture, {10, 30}, 20);
  EXPECT_EQ(picture(30, 12), ColorOf(100, range));
  EXPECT_EQ(picture(229, 12), ColorOf(0, range));
  EXPECT_EQ(picture(230, 12), cv::Vec3b::all(255)) << "bar is longer than asked for";
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
