#include "common/geometry/native_ranges.h"

#include <gmock/gmock.h>

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace sprout {
namespace {

const cv::Size kSensor{48, 32};

// Ranges in whole mm, as a sensor with some noise gives: two walls, and no return in one corner.
TofImage SensorImage(cv::Size size = kSensor) {
  TofImage tof{.depth_m = cv::Mat1f(size), .amplitude = cv::Mat1f(size)};
  cv::RNG random(3);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const double wall_mm = x < size.width / 2 ? 1200 + 3 * y : 2300 - 4 * x;
      tof.depth_m(y, x) = static_cast<float>(std::round(wall_mm + random.gaussian(8)) / 1000);
      tof.amplitude(y, x) = static_cast<float>(100 * y + x);
    }
  }
  tof.depth_m(cv::Rect(0, 0, size.width / 3, size.height / 3)) = 0;
  return tof;
}

TofImage Enlarged(const TofImage& tof, cv::Size size, int interpolation) {
  TofImage enlarged;
  cv::resize(tof.depth_m, enlarged.depth_m, size, 0, 0, interpolation);
  cv::resize(tof.amplitude, enlarged.amplitude, size, 0, 0, interpolation);
  return enlarged;
}

TofCamera CameraOf(cv::Size size) {
  TofCamera camera;
  camera.width = size.width;
  camera.height = size.height;
  camera.fx = size.width;
  camera.fy = size.height;
  camera.cx = (size.width - 1) / 2.0;
  camera.cy = (size.height - 1) / 2.0;
  return camera;
}

std::optional<NativeRanges> Find(const TofImage& tof) {
  return FindNativeRanges(tof, CameraOf(tof.depth_m.size()));
}

bool AreEqual(const cv::Mat1f& one, const cv::Mat1f& other) {
  return one.size() == other.size() && cv::countNonZero(one != other) == 0;
}

TEST(NativeRanges, OfRepeatedPixelsAreTheSensors) {
  const TofImage sensor = SensorImage();
  for (const cv::Size size :
       {cv::Size(96, 64), cv::Size(480, 320), cv::Size(501, 333), cv::Size(640, 101)}) {
    const auto native = Find(Enlarged(sensor, size, cv::INTER_NEAREST));
    ASSERT_TRUE(native) << size;
    EXPECT_TRUE(AreEqual(native->tof.depth_m, sensor.depth_m)) << size;
    EXPECT_TRUE(AreEqual(native->tof.amplitude, sensor.amplitude)) << size;
    const TofCamera expected = CameraOf(kSensor);
    EXPECT_EQ(native->camera.width, expected.width);
    EXPECT_EQ(native->camera.height, expected.height);
    EXPECT_NEAR(native->camera.fx, expected.fx, 1e-9);
    EXPECT_NEAR(native->camera.fy, expected.fy, 1e-9);
    EXPECT_NEAR(native->camera.cx, expected.cx, 1e-9);
    EXPECT_NEAR(native->camera.cy, expected.cy, 1e-9);
  }
}

TEST(NativeRanges, OfLinearInterpolationAreTheSensors) {
  const TofImage sensor = SensorImage();
  for (const cv::Size size : {cv::Size(240, 160), cv::Size(480, 320), cv::Size(501, 333)}) {
    TofImage enlarged = Enlarged(sensor, size, cv::INTER_LINEAR);
    const auto of_numbers = Find(enlarged);
    ASSERT_TRUE(of_numbers) << size;
    ASSERT_EQ(of_numbers->tof.depth_m.size(), kSensor);
    EXPECT_LT(cv::norm(of_numbers->tof.depth_m, sensor.depth_m, cv::NORM_INF), 1e-5) << size;
    EXPECT_LT(cv::norm(of_numbers->tof.amplitude, sensor.amplitude, cv::NORM_INF), 0.05) << size;
    for (float& depth_m : enlarged.depth_m) depth_m = std::round(1000 * depth_m) / 1000;
    const auto of_mm = Find(enlarged);
    ASSERT_TRUE(of_mm) << size;
    ASSERT_EQ(of_mm->tof.depth_m.size(), kSensor);
    EXPECT_LT(cv::norm(of_mm->tof.depth_m, sensor.depth_m, cv::NORM_INF), 0.004) << size;
  }
}

TEST(NativeRanges, SeedsHavePixelsOfTheEnlargedImage) {
  const auto native = Find(Enlarged(SensorImage(), {480, 320}, cv::INTER_NEAREST));
  ASSERT_TRUE(native);
  Seed seed{.tof_u = 47, .tof_v = 3};
  native->ToEnlarged(seed);
  EXPECT_EQ(seed.tof_u, 475);
  EXPECT_EQ(seed.tof_v, 35);
  Seed stereo{.origin = SeedOrigin::kStereo};
  native->ToEnlarged(stereo);
  EXPECT_EQ(stereo.tof_u, -1);
}

TEST(NativeRanges, AreNotMadeOfOtherImages) {
  EXPECT_FALSE(Find(SensorImage()));
  EXPECT_FALSE(Find(SensorImage({640, 480})));
  EXPECT_FALSE(Find(Enlarged(SensorImage(), {640, 32}, cv::INTER_NEAREST))) << "one axis";
  EXPECT_FALSE(Find(Enlarged(SensorImage({4, 4}), {64, 64}, cv::INTER_NEAREST))) << "zones";
  EXPECT_FALSE(Find({}));

  TofImage flat{.depth_m = cv::Mat1f(cv::Size(640, 480), 1.5F), .amplitude = {}};
  EXPECT_FALSE(Find(flat));
  cv::rectangle(flat.depth_m, cv::Rect(100, 50, 300, 200), 1.25, cv::FILLED);
  EXPECT_FALSE(Find(flat)) << "a box without noise";
  for (int x = 0; x < 640; ++x) flat.depth_m.col(x) += 0.0004F * static_cast<float>(x);
  EXPECT_FALSE(Find(flat)) << "a slanted box without noise";

  TofImage scan{.depth_m = cv::Mat1f(cv::Size(640, 480), 0.0F), .amplitude = {}};
  for (int y = 5; y < 480; y += 12) {
    for (int x = 3; x < 640; x += 10) scan.depth_m(y, x) = 0.01F * static_cast<float>(x + y);
  }
  EXPECT_FALSE(Find(scan)) << "single points";
}

// A scan of 4000 points whose ranges go to all pixels that are nearest.
cv::Mat1f SpreadPoints(cv::Size size, cv::Mat1f& points) {
  points = cv::Mat1f(size, 0);
  cv::Mat1b empty(size, uint8_t{1});
  cv::RNG random(5);
  for (int y = 2; y < size.height; y += 5) {
    for (int x = 2 + y % 3; x < size.width; x += 3) {
      points(y, x) = static_cast<float>(5 + 0.02 * x + 0.05 * y + random.gaussian(0.05));
      empty(y, x) = 0;
    }
  }
  cv::Mat1f distances;
  cv::Mat1i nearest;
  cv::distanceTransform(empty, distances, nearest, cv::DIST_L2, 5, cv::DIST_LABEL_PIXEL);
  std::vector<float> ranges(static_cast<size_t>(size.area()) + 1);
  for (int i = 0; i < size.area(); ++i) {
    const cv::Point at(i % size.width, i / size.width);
    if (empty(at) == 0) ranges[static_cast<size_t>(nearest(at))] = points(at);
  }
  cv::Mat1f spread(size);
  for (int i = 0; i < size.area(); ++i) {
    const cv::Point at(i % size.width, i / size.width);
    spread(at) = ranges[static_cast<size_t>(nearest(at))];
  }
  return spread;
}

TEST(NativeRanges, OfPointsThatWereSpreadAreThePoints) {
  cv::Mat1f points;
  const cv::Mat1f spread = SpreadPoints({300, 200}, points);
  const auto native = Find({.depth_m = spread, .amplitude = {}});
  ASSERT_TRUE(native);
  ASSERT_EQ(native->tof.depth_m.size(), spread.size());
  EXPECT_GT(cv::countNonZero(native->tof.depth_m), 0.95 * cv::countNonZero(points));
  EXPECT_LE(cv::countNonZero(native->tof.depth_m), cv::countNonZero(points));
  cv::Mat1f around;
  cv::dilate(points, around, cv::Mat1b::ones(3, 3));  // no two points are so near
  // Those at the border have less around them on one side.
  EXPECT_LT(cv::countNonZero((native->tof.depth_m > 0) & (native->tof.depth_m != around)), 20);
}

TEST(NativeRanges, FewStepsAreNoPoints) {
  cv::Mat1f points;
  cv::Mat1f steps = SpreadPoints({300, 200}, points);
  cv::GaussianBlur(steps, steps, {}, 3);
  for (float& depth_m : steps) depth_m = std::round(10 * depth_m) / 10;
  EXPECT_FALSE(Find({.depth_m = steps, .amplitude = {}}));
  cv::RNG random(7);  // a tenth are flying pixels
  for (float& depth_m : steps) {
    if (random.uniform(0, 10) == 0) depth_m *= random.uniform(0.5F, 1.5F);
  }
  EXPECT_FALSE(Find({.depth_m = steps, .amplitude = {}}));
}

TEST(NativeRanges, NoReturnThatIsNoNumberMayBeEnlarged) {
  TofImage sensor = SensorImage();
  sensor.depth_m.setTo(NAN, sensor.depth_m == 0);
  EXPECT_TRUE(Find(Enlarged(sensor, {480, 320}, cv::INTER_NEAREST)));
  EXPECT_TRUE(Find(Enlarged(sensor, {480, 320}, cv::INTER_LINEAR)));
}

}  // namespace
}  // namespace sprout
