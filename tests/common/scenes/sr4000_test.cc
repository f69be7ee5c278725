#include "common/scenes/sr4000.h"

#include <gmock/gmock.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "common/geometry/projection.h"
#include "tests/common/config/with.h"
#include "tests/common/scenes/some_pair.h"
#include "tests/common/testing/thrown.h"

namespace sprout::scenes {
namespace {

constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
const std::string kQuiet = "depth_noise_m: 0 ";

// A wall that fills the view.
TofSamples Wall(float depth_m, float albedo) {
  TofSamples samples({176, 144});
  samples.depth_m = depth_m;
  samples.albedo = albedo;
  return samples;
}

// Another wall from a ToF column on; quarters of a pixel count.
void SetRight(TofSamples& samples, double tof_column, float depth_m, float albedo) {
  const int first = static_cast<int>(std::lround(tof_column * TofSamples::kPerSide));
  samples.depth_m.colRange(first, samples.depth_m.cols) = depth_m;
  samples.albedo.colRange(first, samples.albedo.cols) = albedo;
}

TofImage Measure(const TofSamples& samples, const std::string& config = "", uint32_t seed = 1,
                 int64_t frame = 0) {
  return Sr4000(SomePair(), With<Sr4000Config>(config), seed).Measure(samples, frame).tof;
}

int Returns(const TofImage& tof) { return cv::countNonZero(tof.depth_m == tof.depth_m); }

// Root mean square error in columns [first, last).
double Deviation(const TofImage& tof, int first, int last, double truth_m) {
  double sum = 0;
  for (float depth_m : cv::Mat1f(tof.depth_m.colRange(first, last))) {
    sum += (depth_m - truth_m) * (depth_m - truth_m);
  }
  return std::sqrt(sum / (tof.depth_m.rows * (last - first)));
}

bool SameBytes(const TofImage& a, const TofImage& b) {
  const size_t bytes = a.depth_m.total() * sizeof(float);
  return std::memcmp(a.depth_m.data, b.depth_m.data, bytes) == 0 &&
         std::memcmp(a.amplitude.data, b.amplitude.data, bytes) == 0;
}

TEST(Sr4000, HasTheStatedNoiseAtTheMedianAmplitude) {
  const TofImage tof = Measure(Wall(2, 0.5));
  EXPECT_NEAR(Deviation(tof, 0, 176, 2), 0.004, 0.0001);
  EXPECT_NEAR(cv::mean(tof.depth_m)[0], 2, 0.0001);
  for (float amplitude : tof.amplitude) ASSERT_NEAR(amplitude, 500, 0.01);
}

TEST(Sr4000, IsNoisierFarAwayAndOnDarkSurfaces) {
  TofSamples samples = Wall(1.5, 0.5f);
  SetRight(samples, 88, 3, 0.5f);
  const TofImage by_distance = Measure(samples);
  EXPECT_GT(Deviation(by_distance, 88, 176, 3), 2 * Deviation(by_distance, 0, 88, 1.5));
  EXPECT_NEAR(by_distance.amplitude(9, 9) / by_distance.amplitude(9, 99), 4, 1e-3);

  samples = Wall(2, 0.8f);
  SetRight(samples, 88, 2, 0.2f);
  const TofImage by_darkness = Measure(samples);
  EXPECT_GT(Deviation(by_darkness, 88, 176, 2), 2 * Deviation(by_darkness, 0, 88, 2));
  EXPECT_NEAR(by_darkness.amplitude(9, 9) / by_darkness.amplitude(9, 99), 4, 1e-3);
}

TEST(Sr4000, IsLimitedByItsOwnLightAtNightAndByTheSunByDay) {
  TofSamples samples = Wall(2, 0.8f);
  SetRight(samples, 80, 2, 0.2f);  // the larger part: the median; the other is 4 times as bright
  const auto deviation = [&](const char* config) {
    return Deviation(Measure(samples, config), 0, 80, 2);
  };
  EXPECT_NEAR(deviation("ambient_amplitude: 0"), 0.004 / 2, 0.0001);
  EXPECT_NEAR(deviation("ambient_amplitude: 60000"), 0.004 / 4, 0.0001);
}

TEST(Sr4000, HasNoReturnFromVeryDarkSurfaces) {
  TofSamples samples = Wall(2, 0.5f);
  SetRight(samples, 100, 2, 0.049f);  // just below a tenth of the median
  SetRight(samples, 120, 2, 0.051f);
  SetRight(samples, 140, 2, 0);
  const TofImage tof = Measure(samples);
  EXPECT_FALSE(std::isnan(tof.depth_m(50, 99)));
  EXPECT_TRUE(std::isnan(tof.depth_m(50, 100)));
  EXPECT_NEAR(tof.amplitude(50, 100), 49, 0.01);
  EXPECT_FALSE(std::isnan(tof.depth_m(50, 120)));
  const TofImage all = Measure(samples, "min_amplitude: 0");
  EXPECT_FALSE(std::isnan(all.depth_m(50, 100)));
  EXPECT_TRUE(std::isnan(all.depth_m(50, 140)));  // no light at all
}

TEST(Sr4000, HasNoReturnWhereMostOfThePixelIsUnknown) {
  TofSamples samples = Wall(2, 0.5f);
  SetRight(samples, 100.5, kUnknown, 0);
  EXPECT_FALSE(std::isnan(Measure(samples).depth_m(50, 100)));
  SetRight(samples, 100.25, kUnknown, 0);
  const TofImage tof = Measure(samples);
  EXPECT_FALSE(std::isnan(tof.depth_m(50, 99)));
  EXPECT_TRUE(std::isnan(tof.depth_m(50, 100)));
  EXPECT_EQ(tof.amplitude(50, 130), 0);
}

TEST(Sr4000, HasFlyingPixelsAtDepthEdgesOnly) {
  TofSamples samples = Wall(2, 0.4f);
  SetRight(samples, 100.25, 1, 0.1f);  // both send the same light back
  const TofImage tof = Measure(samples, kQuiet);
  for (int u = 0; u < 176; ++u) {
    EXPECT_NEAR(tof.depth_m(70, u), u < 100 ? 2 : u > 100 ? 1 : 1.25, 1e-6) << u;
  }
  const auto at_the_edge = [&](const std::string& more) {
    return Measure(samples, kQuiet + more).depth_m(70, 100);
  };
  EXPECT_NEAR(at_the_edge("flying_pixels: 0.5"), 1.125, 1e-6);
  EXPECT_NEAR(at_the_edge("flying_pixels: 0"), 1, 1e-6);
}

TEST(Sr4000, SpreadsAnEdgeOverTheFootprintOfAPixel) {
  TofSamples samples = Wall(2, 0.5F);
  SetRight(samples, 88, 3, 0.5F);
  const auto between = [&](int footprint_px) {
    const TofImage tof = Measure(samples, kQuiet + "footprint_px: " + std::to_string(footprint_px));
    int count = 0;
    for (int u = 0; u < 176; ++u) count += tof.depth_m(70, u) > 2.01F && tof.depth_m(70, u) < 2.99F;
    return count;
  };
  EXPECT_EQ(between(1), 0);
  EXPECT_EQ(between(3), 2);
  EXPECT_EQ(between(5), 4);
}

TEST(Sr4000, DropsPixelsThatItCanTellToBeMixed) {
  TofSamples samples = Wall(2, 0.5F);
  SetRight(samples, 88, 3, 0.5F);
  EXPECT_EQ(Returns(Measure(samples, "footprint_px: 3 mixed_percent: 49")), 174 * 144);
  EXPECT_EQ(Returns(Measure(samples, "footprint_px: 3 mixed_percent: 51")), 176 * 144);
}

// A wall that slopes away and darkens to the right, so that no two columns are alike.
TofSamples Slope(float near_m, float far_m) {
  TofSamples samples = Wall(near_m, 0.5F);
  for (int x = 0; x < samples.depth_m.cols; ++x) {
    const float share = static_cast<float>(x) / static_cast<float>(samples.depth_m.cols);
    samples.depth_m.col(x) = near_m + share * (far_m - near_m);
    samples.albedo.col(x) = 0.9F - 0.5F * share;
  }
  return samples;
}

TEST(Sr4000, IsBlindToExactlyTheShareOfReturnsWithTheLowestAmplitude) {
  const TofSamples samples = Slope(2, 3);
  const TofImage all = Measure(samples);
  ASSERT_EQ(Returns(all), 176 * 144);
  for (const int percent : {25, 50, 75, 100}) {
    const TofImage tof = Measure(samples, "blind_percent: " + std::to_string(percent));
    EXPECT_EQ(Returns(tof), std::lround((1 - percent / 100.0) * 176 * 144));
    float weakest_kept = 1e9F;
    float strongest_gone = 0;
    for (int i = 0; i < 176 * 144; ++i) {
      EXPECT_EQ(tof.amplitude(i), all.amplitude(i));
      if (std::isnan(tof.depth_m(i))) {
        strongest_gone = std::max(strongest_gone, tof.amplitude(i));
      } else {
        EXPECT_EQ(tof.depth_m(i), all.depth_m(i));
        weakest_kept = std::min(weakest_kept, tof.amplitude(i));
      }
    }
    EXPECT_GE(weakest_kept, strongest_gone);
  }
}

TEST(Sr4000, TakesEquallyWeakReturnsInTheOrderOfThePixels) {
  const TofImage tof = Measure(Wall(2, 0.5F), "blind_percent: 50");
  EXPECT_EQ(cv::countNonZero(tof.depth_m.rowRange(0, 72) == tof.depth_m.rowRange(0, 72)), 0);
  EXPECT_EQ(Returns(tof), 72 * 176);
}

TEST(Sr4000, LeavesOutAllButOnePixelInSoMany) {
  const TofImage all = Measure(Wall(2, 0.5F));
  const TofImage tof = Measure(Wall(2, 0.5F), "every_px: 4");
  EXPECT_EQ(Returns(tof), 44 * 36);
  EXPECT_EQ(tof.depth_m(8, 12), all.depth_m(8, 12));
  EXPECT_TRUE(std::isnan(tof.depth_m(8, 13)));
  EXPECT_TRUE(std::isnan(tof.depth_m(9, 12)));
  EXPECT_EQ(Returns(Measure(Wall(2, 0.5F), "every_px: 1.5")), 117 * 96) << "two of three";
}

TEST(Sr4000, HasNoReturnBeyondItsRange) {
  const Sr4000 camera(SomePair(), With<Sr4000Config>(kQuiet + "max_range_m: 3"), 1);
  const TofProjector projector({.pair = SomePair(), .tof = camera.calibrated()});
  const TofImage tof = camera.Measure(Slope(2, 4), 0).tof;
  const TofImage all = Measure(Slope(2, 4), kQuiet);
  int beyond = 0;
  for (int v = 0; v < 144; ++v) {
    for (int u = 0; u < 176; ++u) {
      const double range_m = all.depth_m(v, u) * projector.ray(u, v).norm();
      if (std::abs(range_m - 3) < 1e-5) continue;
      EXPECT_EQ(std::isnan(tof.depth_m(v, u)), range_m > 3) << u << ", " << v;
      beyond += range_m > 3;
    }
  }
  EXPECT_GT(beyond, 1000);
}

TEST(Sr4000, TellsARangeOnlyModuloItsAmbiguity) {
  const TofImage all = Measure(Slope(4, 6), kQuiet);
  const Sr4000 camera(SomePair(), With<Sr4000Config>(kQuiet + "ambiguity_range_m: 5"), 1);
  const TofProjector projector({.pair = SomePair(), .tof = camera.calibrated()});
  const TofImage tof = camera.Measure(Slope(4, 6), 0).tof;
  for (int v = 0; v < 144; v += 9) {
    for (int u = 0; u < 176; ++u) {
      const double length = projector.ray(u, v).norm();
      const double range_m = all.depth_m(v, u) * length;
      if (std::abs(range_m - 5) < 1e-5) continue;
      const double expected_m = range_m < 5 ? range_m : range_m - 5;
      EXPECT_NEAR(tof.depth_m(v, u) * length, expected_m, 1e-5) << u << ", " << v;
    }
  }
}

TEST(Sr4000, WrapsTheStatedShareOfReturnsWhateverTheScaleOfTheScene) {
  for (const float scale : {1.0F, 100.0F}) {
    const TofImage all = Measure(Slope(4 * scale, 6 * scale));
    const TofImage tof = Measure(Slope(4 * scale, 6 * scale), "wrapped_percent: 25");
    int wrapped = 0;
    for (int i = 0; i < 176 * 144; ++i) wrapped += tof.depth_m(i) < all.depth_m(i);
    EXPECT_EQ(wrapped, 176 * 144 / 4);
  }
}

TEST(Sr4000, MeasuresDarkSurfacesTooNearByAmplitude) {
  TofSamples samples = Wall(2, 0.3F);
  SetRight(samples, 100, 2, 0.9F);  // three times the median
  const TofImage tof = Measure(samples, kQuiet + "amplitude_error_m: 0.01");
  const TofImage right = Measure(samples, kQuiet);
  EXPECT_EQ(tof.depth_m(72, 40), right.depth_m(72, 40));
  // 10 mm · (3 / (3 + 1) − 1/2) along a ray that is nearly the axis.
  EXPECT_NEAR(tof.depth_m(72, 110) - right.depth_m(72, 110), 0.0025, 5e-5);
}

TEST(Sr4000, HasStrayLightOnlyWhenAsked) {
  TofSamples samples = Wall(3, 0.3F);
  SetRight(samples, 100, 1, 0.9F);
  const TofImage right = Measure(samples);
  EXPECT_LT(Measure(samples, "scatter: 0.02").depth_m(72, 40), right.depth_m(72, 40) - 0.01);
  EXPECT_TRUE(SameBytes(Measure(samples, "scatter: 0"), right));
  // A corner: its middle is the farthest.
  for (int x = 0; x < samples.depth_m.cols; ++x) {
    const float share = static_cast<float>(x) / static_cast<float>(samples.depth_m.cols);
    samples.depth_m.col(x) = 3 - 2 * std::abs(share - 0.5F);
  }
  const TofImage corner = Measure(samples);
  EXPECT_GT(Measure(samples, "multipath: 0.3").depth_m(72, 80), corner.depth_m(72, 80) + 0.001);
}

TEST(Sr4000, MistakesWhatMovesBetweenItsPhaseImages) {
  const Sr4000 camera(SomePair(), With<Sr4000Config>(kQuiet + "focal_px: 220"), 1);
  const TofSamples still = Wall(2, 0.5F);
  const TofImage right = camera.Measure(still, 0).tof;
  std::vector<TofSamples> images(4, still);
  EXPECT_LT(cv::norm(camera.Measure(still, 0, images).tof.depth_m, right.depth_m, cv::NORM_INF),
            1e-6);
  // Comes nearer by 1 cm from one image to the next: by the time of images 0 to 3, on average by
  // 1.5 cm; an edge that moves is wrong by much more.
  for (size_t k = 0; k < 4; ++k) images[k] = Wall(2 - 0.01F * static_cast<float>(k), 0.5F);
  const double nearer =
      right.depth_m(72, 88) - camera.Measure(still, 0, images).tof.depth_m(72, 88);
  EXPECT_GT(nearer, 0.005);
  EXPECT_LT(nearer, 0.03);
  TofSamples edge = still;
  SetRight(edge, 90, 1, 0.5F);
  images = {still, still, edge, edge};
  const TofImage moving = camera.Measure(still, 0, images).tof;
  EXPECT_GT(std::abs(moving.depth_m(72, 95) - 2), 0.1);
  EXPECT_NEAR(moving.depth_m(72, 80), 2, 1e-6);
}

TEST(Sr4000, GivesTheSameBytesForTheSameFrameAndSeedOnly) {
  const TofSamples samples = Wall(2, 0.5f);
  const TofImage tof = Measure(samples, "", 7, 3);
  EXPECT_TRUE(SameBytes(tof, Measure(samples, "", 7, 3)));
  EXPECT_FALSE(SameBytes(tof, Measure(samples, "", 8, 3)));
  EXPECT_FALSE(SameBytes(tof, Measure(samples, "", 7, 4)));
}

TEST(Sr4000, RefusesParametersOutOfRange) {
  EXPECT_THAT(Thrown<ConfigError>([&] { Measure(Wall(1, 1), "flying_pixels: 1.5"); }),
              testing::HasSubstr("capture.sr4000.flying_pixels = 1.5"));
}

}  // namespace
}  // namespace sprout::scenes
