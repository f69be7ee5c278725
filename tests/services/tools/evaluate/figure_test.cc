#include "services/tools/evaluate/figure.h"

#include <gtest/gtest.h>

namespace sprout::evaluate {
namespace {

cv::Mat3b Filled(cv::Size size, const cv::Vec3b& color) { return cv::Mat3b(size, color); }

const ScaleContent kScale{.axes = {{{0, 4}, "px"}}};

int CountColor(const cv::Mat3b& picture, const cv::Vec3b& color) {
  cv::Mat1b same;
  cv::inRange(picture, color, color, same);
  return cv::countNonZero(same);
}

TEST(Figure, ShowsEveryPictureAtOneWidth) {
  const cv::Vec3b red(0, 0, 255);
  const cv::Vec3b blue(255, 0, 0);
  const cv::Mat3b figure = Figure(
      {"a", "b"}, {{{{Filled({640, 480}, red), "1 %"}, {Filled({640, 480}, blue), ""}}, kScale},
                   {{{Filled({160, 80}, blue), ""}, {Filled({160, 80}, blue), "2 %"}}, kScale}});
  EXPECT_EQ(CountColor(figure, red), 320 * 240);
  EXPECT_EQ(CountColor(figure, blue), 320 * (240 + 2 * 160));
}

TEST(Figure, ExplainsTheColorsOfEachRow) {
  const cv::Mat3b white = Filled({320, 200}, {255, 255, 255});
  const cv::Mat3b figure = Figure({"a"}, {{{{white, ""}}, kScale}, {{{white, ""}}, kScale}});
  EXPECT_GE(CountColor(figure, ColorOf(4, {0, 4})), 2 * 10);
  EXPECT_GE(CountColor(figure, ColorOf(0, {0, 4})), 2 * 10);
}

TEST(Figure, WritesTitlesAndCaptions) {
  const cv::Mat3b white = Filled({320, 200}, {255, 255, 255});
  const cv::Mat3b nothing = Figure({""}, {{{{white, ""}}, kScale}});
  for (const auto& [title, caption] : {std::pair("title", ""), std::pair("", "88.8 %")}) {
    const cv::Mat3b written = Figure({title}, {{{{white, caption}}, kScale}});
    EXPECT_LT(CountColor(written, {255, 255, 255}), CountColor(nothing, {255, 255, 255}) - 100);
  }
}

}  // namespace
}  // namespace sprout::evaluate
