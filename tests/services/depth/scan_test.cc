#include "services/depth/scan.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace sprout::depth {
namespace {

constexpr float kNothing = std::numeric_limits<float>::infinity();

// f·b = 10 px·m: 10 px are 1 m. The image sees 45° to either side.
constexpr RectifiedPair kScannedPair{.width = 201,
                                     .height = 21,
                                     .focal_px = 100,
                                     .cx = 100,
                                     .cy = 10,
                                     .cx_right = 100,
                                     .baseline_m = 0.1};

DisparityImage Wall(int px) {
  return DisparityImage(cv::Mat1s(21, 201, static_cast<int16_t>(32 * px)));
}

constexpr ScanBand kBand{.min_height_m = -0.05, .max_height_m = 0.05, .step_deg = 1};

PlanarScan Scan(const DisparityImage& map, const Pose& base_from_left = LevelFromLeft(),
                const ScanBand& band = kBand) {
  return ScanOf(map, kScannedPair, base_from_left, band).value();
}

double Degrees(const PlanarScan& scan, size_t beam) {
  return (scan.first + static_cast<int>(beam)) * scan.step_rad * 180 / std::numbers::pi;
}

TEST(ScanOf, CoversTheImageFromRightToLeft) {
  const PlanarScan scan = Scan(Wall(10));
  EXPECT_EQ(scan.first, -45);
  EXPECT_EQ(scan.ranges_m.size(), 91U);
  EXPECT_DOUBLE_EQ(scan.step_rad, std::numbers::pi / 180);
}

// By trigonometry, pixel by pixel.
TEST(ScanOf, HasTheNearestPointOfEveryDirection) {
  DisparityImage map = Wall(10);
  map.counts()(cv::Rect(150, 8, 10, 5)) = 640;  // a pole at 0.5 m, right of the middle
  std::vector<double> expected(91, std::numeric_limits<double>::infinity());
  for (int v = 0; v < 21; ++v) {
    for (int u = 0; u < 201; ++u) {
      const double z = 320.0 / map.counts()(v, u);
      if (std::abs((10 - v) * z / 100) > 0.05) continue;
      const double y = (100 - u) * z / 100;
      const auto beam = std::lround(std::atan2(y, z) * 180 / std::numbers::pi) + 45;
      double& range = expected[static_cast<size_t>(beam)];
      range = std::min(range, std::hypot(y, z));
    }
  }
  const PlanarScan scan = Scan(map);
  ASSERT_EQ(scan.ranges_m.size(), expected.size());
  for (size_t i = 0; i < expected.size(); ++i) {
    EXPECT_NEAR(double{scan.ranges_m[i]}, expected[i], 1e-6) << Degrees(scan, i) << " degrees";
  }
  EXPECT_NEAR(double{scan.ranges_m[45 - 29]}, 0.5 * std::hypot(1, 0.55), 0.01);
}

TEST(ScanOf, LooksOnlyWithinTheBand) {
  DisparityImage map(kScannedPair.size());
  map.counts()(0, 100) = 320;   // 1 m away, 10 cm up
  map.counts()(20, 110) = 320;  // and 10 cm down
  const auto seen = [&](double low, double high) {
    const PlanarScan scan =
        Scan(map, LevelFromLeft(), {.min_height_m = low, .max_height_m = high, .step_deg = 1});
    std::vector<int> degrees;
    for (size_t i = 0; i < scan.ranges_m.size(); ++i) {
      if (scan.ranges_m[i] != kNothing) degrees.push_back(scan.first + static_cast<int>(i));
    }
    return degrees;
  };
  EXPECT_EQ(seen(-0.05, 0.05), std::vector<int>());
  EXPECT_EQ(seen(0.05, 0.2), (std::vector{0}));
  EXPECT_EQ(seen(-0.2, -0.05), (std::vector{-6}));
  EXPECT_EQ(seen(-0.2, 0.2), (std::vector{-6, 0}));
}

// Turned by 90° to the left on the robot, 1 m over its origin.
TEST(ScanOf, TurnsWithTheCameraOnTheRobotAndMeasuresFromIt) {
  const Eigen::Quaterniond left_turn(
      Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitZ()));
  Pose base_from_left{.rotation = left_turn * Eigen::Quaterniond(LevelFromLeft().rotation),
                      .translation_m = {5, 6, 1}};
  const PlanarScan scan =
      Scan(Wall(10), base_from_left, {.min_height_m = 0.95, .max_height_m = 1.05, .step_deg = 1});
  EXPECT_EQ(scan.first, 45);
  ASSERT_EQ(scan.ranges_m.size(), 91U);
  EXPECT_NEAR(double{scan.ranges_m[45]}, 1, 1e-6);
}

TEST(ScanOf, LooksBackwardsToo) {
  const Eigen::Quaterniond around(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitZ()));
  const PlanarScan scan =
      Scan(Wall(10), {.rotation = around * Eigen::Quaterniond(LevelFromLeft().rotation),
                      .translation_m = Eigen::Vector3d::Zero()});
  EXPECT_EQ(scan.first, 135);
  EXPECT_EQ(scan.ranges_m.size(), 91U);
  EXPECT_TRUE(std::none_of(scan.ranges_m.begin(), scan.ranges_m.end(),
                           [](float range) { return range == kNothing; }));
}

TEST(ScanOf, IsRefusedForACameraThatLooksDown) {
  // Its axis is the robot's −z.
  const Pose down{.rotation = {0, 1, 0, 0}, .translation_m = {0, 0, 2}};
  const auto scan = ScanOf(Wall(10), kScannedPair, down, kBand);
  ASSERT_FALSE(scan);
  EXPECT_THAT(scan.error().text, ::testing::HasSubstr("straight above or below"));
}

TEST(LevelFromLeft, LooksForward) {
  const Pose level = LevelFromLeft();
  EXPECT_EQ(level.rotation * Eigen::Vector3d(1, 2, 3), Eigen::Vector3d(3, -1, -2));
}

}  // namespace
}  // namespace sprout::depth
