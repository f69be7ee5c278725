#include "services/refine/range/sensor_place.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace sprout::refine {
namespace {

const cv::Size kImage(600, 400);
constexpr double kSpacingPx = 5;

// A wall at 20 px, before it three boxes at 40 to 60 px.
double BoxesPx(const cv::Point2d& at) {
  if (cv::Rect2d(80, 60, 90, 120).contains(at)) return 60;
  if (cv::Rect2d(300, 200, 120, 110).contains(at)) return 50;
  if (cv::Rect2d(430, 70, 60, 80).contains(at)) return 40;
  return 20 + 0.01 * at.x;
}

Seed SeedAt(double u, double v, double disparity) {
  return {.u = static_cast<float>(u),
          .v = static_cast<float>(v),
          .u_right = static_cast<float>(u - disparity)};
}

// What stereo finds: a match every 8 px.
std::vector<Seed> Matches() {
  std::vector<Seed> matches;
  for (double v = 4; v < kImage.height; v += 8) {
    for (double u = 4; u < kImage.width; u += 8) matches.push_back(SeedAt(u, v, BoxesPx({u, v})));
  }
  return matches;
}

// The points of a sensor, as a function of their positions in the left image.
std::vector<ProjectedPoint> Points(const std::function<double(const cv::Point2d&)>& disparity) {
  std::vector<ProjectedPoint> points;
  for (double v = 2; v < kImage.height; v += kSpacingPx) {
    for (double u = 2; u < kImage.width; u += kSpacingPx) {
      points.push_back({.seed = SeedAt(u, v, disparity({u, v}))});
    }
  }
  return points;
}

SensorPlace Find(const std::vector<ProjectedPoint>& raw,
                 const std::vector<ProjectedPoint>& corrected) {
  return FindSensorPlace({raw, corrected, {kSpacingPx, kSpacingPx}, kImage}, Matches(), 2);
}

TEST(SensorPlace, IsRightForASensorThatLooksWhereItShould) {
  const auto points = Points(BoxesPx);
  const SensorPlace place = Find(points, points);
  EXPECT_FALSE(place.is_displaced);
  EXPECT_GT(place.agree_as_is, 0.9);
}

TEST(SensorPlace, FindsWhereADisplacedSensorBelongs) {
  for (const cv::Point2d& move_px : {cv::Point2d(24, 0), {-40, 30}, {0, -60}, {70, 20}}) {
    const auto points = Points([&](const cv::Point2d& at) { return BoxesPx(at + move_px); });
    const SensorPlace place = Find(points, points);
    EXPECT_TRUE(place.is_displaced) << move_px;
    EXPECT_GT(place.agree_moved, 0.9) << move_px;
    EXPECT_NEAR(place.move_px.x, move_px.x, 2 * kSpacingPx) << move_px;
    EXPECT_NEAR(place.move_px.y, move_px.y, 2 * kSpacingPx) << move_px;
  }
}

TEST(SensorPlace, FindsALensThatIsNotTheCalibratedOne) {
  const cv::Point2d middle(kImage.width / 2.0, kImage.height / 2.0);
  for (const double spread : {0.75, 0.9, 1.12, 1.3}) {
    const auto points =
        Points([&](const cv::Point2d& at) { return BoxesPx(middle + spread * (at - middle)); });
    const SensorPlace place = Find(points, points);
    EXPECT_TRUE(place.is_displaced) << spread;
    EXPECT_NEAR(place.spread, spread, 0.06) << spread;
  }
}

// 30 px are the disparity of infinity.
TEST(SensorPlace, FindsRangesThatAreTooLongOrTooShort) {
  for (const double scale : {0.75, 0.9, 1.1, 1.3}) {
    const auto points =
        Points([&](const cv::Point2d& at) { return 30 + (BoxesPx(at) - 30) / scale; });
    PlacedPoints placed{points, points, {kSpacingPx, kSpacingPx}, kImage, 30};
    const SensorPlace place = FindSensorPlace(placed, Matches(), 0.5);
    EXPECT_TRUE(place.is_displaced) << scale;
    EXPECT_NEAR(place.scale, scale, 0.03) << scale;
  }
}

// An edge is only seen to a pixel of the sensor.
TEST(SensorPlace, IsRightForASensorThatIsOffByLessThanItsPixel) {
  const auto points =
      Points([](const cv::Point2d& at) { return BoxesPx(at + cv::Point2d(kSpacingPx - 1, 0)); });
  const SensorPlace place = Find(points, points);
  EXPECT_NEAR(place.move_px.x, kSpacingPx, kSpacingPx);
  EXPECT_FALSE(place.is_displaced);
}

// Multi-path moves whole surfaces, and refinement takes that off; none of it is a place.
TEST(SensorPlace, IsRightForASensorThatIsOffInDepthAndWasCorrected) {
  const auto raw = Points([](const cv::Point2d& at) {
    return BoxesPx(at) - 4 - 3 * std::exp(-((at.x - 300) * (at.x - 300)) / 5000);
  });
  const SensorPlace place = Find(raw, Points(BoxesPx));
  EXPECT_FALSE(place.is_displaced);
}

// No other place explains them better, so where they look cannot be told.
TEST(SensorPlace, IsNotDisplacedForAnotherScene) {
  const auto points = Points(
      [](const cv::Point2d& at) { return 40 + 15 * std::sin(at.x / 31) * std::cos(at.y / 23); });
  EXPECT_FALSE(Find(points, points).is_displaced);
}

// Better elsewhere is not enough: there they have to fit.
TEST(SensorPlace, IsNotDisplacedWherePointsFitNowhere) {
  const auto points = Points([](const cv::Point2d& at) {
    const bool is_wrong = static_cast<int>(at.x * 7 + at.y * 13) % 4 == 0;
    return BoxesPx(at + cv::Point2d(40, 0)) + (is_wrong ? 30 : 0);
  });
  const SensorPlace place = Find(points, points);
  EXPECT_GT(place.agree_moved, place.agree_as_is + 0.04);
  EXPECT_FALSE(place.is_displaced);
}

// Only edges show a small move, so it changes few matches; as long as stereo has fewer wrong.
TEST(SensorPlace, NeedsLessWhereStereoErrsLess) {
  const auto points =
      Points([](const cv::Point2d& at) { return BoxesPx(at + cv::Point2d(10, 0)); });
  const PlacedPoints placed{points, points, {kSpacingPx, kSpacingPx}, kImage};
  std::vector<Seed> matches = Matches();
  const SensorPlace place = FindSensorPlace(placed, matches, 2);
  EXPECT_LT(place.agree_moved - place.agree_as_is, 0.035);
  EXPECT_TRUE(place.is_displaced);
  for (size_t i = 0; i < matches.size(); i += 20) matches[i].u_right += 30;
  EXPECT_FALSE(FindSensorPlace(placed, matches, 2).is_displaced);
}

TEST(SensorPlace, CannotBeToldFromFewMatches) {
  const auto points =
      Points([](const cv::Point2d& at) { return BoxesPx(at + cv::Point2d(40, 0)); });
  const std::vector<Seed> all = Matches();
  std::vector<Seed> few;
  for (size_t i = 0; i < all.size(); i += 60) few.push_back(all[i]);
  ASSERT_LT(few.size(), 100U);
  const PlacedPoints placed{points, points, {kSpacingPx, kSpacingPx}, kImage};
  EXPECT_TRUE(FindSensorPlace(placed, all, 2).is_displaced);
  EXPECT_FALSE(FindSensorPlace(placed, few, 2).is_displaced);
  EXPECT_FALSE(FindSensorPlace(placed, {}, 2).is_displaced);
}

// A scan of 20 beams, whose points are projected beside their places.
SensorPlace FindOfScan(const std::function<cv::Point2d(const Seed&)>& beside) {
  std::vector<ProjectedPoint> points;
  for (double v = 10; v < kImage.height; v += 20) {
    for (double u = 2; u < kImage.width; u += 4) {
      const double disparity = BoxesPx({u, v});
      const cv::Point2d at = cv::Point2d(u, v) + beside(SeedAt(u, v, disparity));
      points.push_back({.seed = SeedAt(at.x, at.y, disparity)});
    }
  }
  return FindScanPlace({points, points, {4, 20}, kImage}, Matches(), 8, 2);
}

TEST(ScanPlace, IsRightForAScanThatIsWhereItShouldBe) {
  const SensorPlace place = FindOfScan([](const Seed&) { return cv::Point2d(); });
  EXPECT_FALSE(place.is_displaced);
}

TEST(ScanPlace, FindsWhereAScanBelongs) {
  for (const cv::Point2d& off_px : {cv::Point2d(20, 0), {-32, 8}, {24, -30}}) {
    const SensorPlace place = FindOfScan([&](const Seed&) { return off_px; });
    EXPECT_TRUE(place.is_displaced && place.IsMove()) << off_px;
    EXPECT_GT(place.agree_moved, 0.9) << off_px;
    EXPECT_NEAR(place.move_px.x, -off_px.x, 5) << off_px;
    EXPECT_NEAR(place.move_px.y, -off_px.y, 5) << off_px;
  }
}

TEST(ScanPlace, FindsShearedRows) {
  for (const double shear : {0.16, -0.2}) {
    const SensorPlace place = FindOfScan(
        [&](const Seed& seed) { return cv::Point2d(shear * (seed.v - kImage.height / 2.0), 0); });
    EXPECT_TRUE(place.is_displaced && !place.IsMove()) << shear;
    EXPECT_NEAR(place.shear, -shear, 0.03);
  }
}

TEST(ScanPlace, FindsPointsOfTheRightImage) {
  const SensorPlace place =
      FindOfScan([&](const Seed& seed) { return cv::Point2d(-double{seed.disparity()}, 0); });
  EXPECT_TRUE(place.is_displaced && place.in_right_image);
}

TEST(ScanPlace, CannotBeToldWithoutMatches) {
  const std::vector<ProjectedPoint> points = Points(BoxesPx);
  EXPECT_FALSE(FindScanPlace({points, points, {4, 20}, kImage}, {}, 8, 2).is_displaced);
  EXPECT_FALSE(FindScanPlace({{}, {}, {4, 20}, kImage}, Matches(), 8, 2).is_displaced);
}

}  // namespace
}  // namespace sprout::refine
