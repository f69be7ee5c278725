#include "common/picture/color_map.h"

#include <gtest/gtest.h>

#include <array>
#include <limits>

namespace sprout {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

TEST(ColorMap, KeepsPixelsWithoutValueFarFromEveryColorOfTheScale) {
  for (int i = 0; i <= 1000; ++i) {
    const cv::Vec3b color = ColorOf(i, {0, 1000});
    EXPECT_GT(cv::norm(color, kNoValueColor), 120) << "at " << i << " of 1000";
  }
}

// Entries 18, 75, 132, 188 and 246 of the table that Mikhailov published (Turbo, 2019), RGB, 0
// to 1.
TEST(ColorMap, GoesFromBlueToRed) {
  struct Entry {
    double value;
    std::array<double, 3> rgb;
  };
  for (const auto& [value, rgb] :
       {Entry{10, {0.25618, 0.27412, 0.67381}}, Entry{12.5, {0.10026, 0.82955, 0.81389}},
        Entry{15, {0.68494, 0.97941, 0.21602}}, Entry{17.5, {0.99153, 0.54036, 0.14910}},
        Entry{20, {0.59550, 0.05399, 0.00453}}}) {
    const cv::Vec3b color = ColorOf(value, {10, 20});
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR(color[2 - i], 255 * rgb[static_cast<size_t>(i)], 1)
          << "RGB"[i] << " at " << value;
    }
  }
}

TEST(ColorMap, GivesValuesOutsideTheRangeTheColorOfItsNearerEnd) {
  EXPECT_EQ(ColorOf(-5, {10, 20}), ColorOf(10, {10, 20}));
  EXPECT_EQ(ColorOf(500, {10, 20}), ColorOf(20, {10, 20}));
}

TEST(ColorMap, PaintsNanAndInfinityAsNoValue) {
  const cv::Mat1f values = (cv::Mat1f(1, 3) << kNan, 0.5F, -kInfinity);
  const cv::Mat3b colors = Colorize(values, {0, 1});
  EXPECT_EQ(colors(0, 0), kNoValueColor);
  EXPECT_EQ(colors(0, 1), ColorOf(0.5, {0, 1}));
  EXPECT_EQ(colors(0, 2), kNoValueColor);
}

constexpr RectifiedPair kPair{.width = 640,
                              .height = 480,
                              .focal_px = 500,
                              .cx = 320,
                              .cy = 240,
                              .cx_right = 325,
                              .baseline_m = 0.1};

TEST(ColorOfDepth, IsTheColorOfTheDisparity) {
  const ValueRange range_px{8, 64};
  const ValueRange range_m = DepthRange(kPair, range_px);
  EXPECT_DOUBLE_EQ(range_m.min, kPair.DepthFromDisparity(64));
  for (const double px : {7.0, 8.0, 20.0, 35.5, 64.0, 90.0}) {
    EXPECT_EQ(ColorOfDepth(kPair.DepthFromDisparity(px), range_m), ColorOf(px, range_px)) << px;
  }
}

TEST(ColorOfDepth, IsRedNearAndBlueFarAndNothingWithoutADepth) {
  EXPECT_EQ(ColorOfDepth(1, {1, 5}), ColorOf(1, {0, 1}));
  EXPECT_EQ(ColorOfDepth(5, {1, 5}), ColorOf(0, {0, 1}));
  for (const float none : {0.F, -1.F, kNan, kInfinity}) {
    EXPECT_EQ(ColorOfDepth(none, {1, 5}), kNoValueColor) << none;
  }
}

TEST(DepthRange, ReachesToInfinityWhereDisparitiesDo) {
  EXPECT_EQ(InFront(kPair, {-20, 64}), (ValueRange{-5, 64}));
  EXPECT_EQ(InFront(kPair, {-20, -6}), std::nullopt);
  const ValueRange range_m = DepthRange(kPair, {-5, 64});
  EXPECT_EQ(range_m.max, kInfinity);
  EXPECT_EQ(ColorOfDepth(kPair.DepthFromDisparity(20), range_m), ColorOf(20, {-5, 64}));
}

TEST(DepthRange, BeginsInFrontOfTheCamera) {
  TofImage tof;
  for (const float near_m : {1e-6F, 0.03F, 0.3F, 0.5F}) {
    for (const float far_m : {near_m, 8.F, 9'000.F}) {
      tof.depth_m = (cv::Mat1f(1, 2) << near_m, far_m);
      const ValueRange range = DepthRange(tof);
      EXPECT_GT(range.min, 0) << near_m << " to " << far_m;
      EXPECT_LE(range.min, double{near_m});
      EXPECT_GE(range.max, double{far_m});
    }
  }
}

TEST(RoundStep, IsTheNextOneTwoOrFive) {
  EXPECT_DOUBLE_EQ(RoundStep(0.13), 0.2);
  EXPECT_DOUBLE_EQ(RoundStep(0.2), 0.2);
  EXPECT_DOUBLE_EQ(RoundStep(1), 1);
  EXPECT_DOUBLE_EQ(RoundStep(3.3), 5);
  EXPECT_DOUBLE_EQ(RoundStep(51), 100);
}

TEST(RobustRange, IgnoresWildValuesAndRoundsOutward) {
  std::vector<float> values;
  for (int i = 0; i <= 1000; ++i) values.push_back(40.3F + 0.1F * static_cast<float>(i));
  values.push_back(-900);
  values.push_back(1023);
  values.push_back(kInfinity);
  values.push_back(kNan);
  // 1st percentile 41.3, 99th 139.3; a 25th of the span is rounded up to 5.
  EXPECT_EQ(RobustRange(values), (ValueRange{40, 140}));
}

TEST(RobustRange, IsNeverEmpty) {
  EXPECT_EQ(RobustRange({}), (ValueRange{0, 1}));
  EXPECT_EQ(RobustRange({kNan}), (ValueRange{0, 1}));
  EXPECT_EQ(RobustRange({7, 7, 7}), (ValueRange{6, 8}));
}

TEST(RobustRange, HasRoomAroundEqualValuesOfAnySize) {
  constexpr float kLargest = std::numeric_limits<float>::max();
  for (const float value : {0.F, 1e-40F, 7.F, -7.F, 1e15F, 1e20F, kLargest, -kLargest}) {
    const ValueRange range = RobustRange({value, value});
    EXPECT_LT(range.min, double{value});
    EXPECT_GT(range.max, double{value});
    EXPECT_EQ(ColorOf(value, range), ColorOf(0, {-1, 1})) << value;
  }
}

TEST(DisparityRange, CoversMapsAndSeedsTogether) {
  DisparityImage low(cv::Size(10, 10));
  low.counts() = ToCounts(10);
  low.counts()(3, 3) = DisparityImage::kInvalid;
  DisparityImage high(cv::Size(10, 10));
  high.counts() = ToCounts(50);
  const std::array maps{low, high};
  EXPECT_EQ(DisparityRange(maps, {}), (ValueRange{10, 50}));
  const std::vector<Seed> seeds(10, Seed{.u = 100, .v = 5, .u_right = 40});
  EXPECT_EQ(DisparityRange(maps, seeds), (ValueRange{10, 60}));
}

TEST(DepthRange, IgnoresPixelsWithoutReturn) {
  TofImage tof;
  tof.depth_m = (cv::Mat1f(1, 7) << 0.F, -1.F, kNan, 1.F, 2.F, 1e20F, 10'001.F);
  EXPECT_EQ(DepthRange(tof), (ValueRange{1, 2}));
}

}  // namespace
}  // namespace sprout
