#include "common/measure/target_meter.h"

#include <gmock/gmock.h>

#include "common/core/disparity_image.h"
#include "common/core/prior_map.h"
#include "tests/common/measure/flat_target.h"

namespace sprout {
namespace {

using testing::FlatTarget;
using ::testing::HasSubstr;
using testing::kNoDisparity;
using testing::TargetNoise;
using testing::TargetPair;

constexpr double kWithin = 0.02;  // of what was put in

void ExpectNear(const std::optional<double>& value, double put_in) {
  ASSERT_TRUE(value);
  EXPECT_NEAR(*value, put_in, kWithin * std::abs(put_in));
}

TargetMeter MeterFor(const TargetSettings& settings, const RectifiedPair& pair = TargetPair()) {
  return *TargetMeter::For(settings, pair, pair.size());
}

const TargetSettings kWhole = {.region = cv::Rect(0, 0, 320, 240)};

// Depth noise of a disparity noise where the plane is square to the camera.
double DepthNoiseMm(const RectifiedPair& pair, double distance_m, double noise_px) {
  return 1000 * distance_m * distance_m / (pair.focal_px * pair.baseline_m) * noise_px;
}

TEST(TargetMeter, FindsThePlaneThatWasPutIn) {
  const FlatTarget target{.distance_m = 1.6, .horizontal_deg = 6, .vertical_deg = -4};
  TargetSettings settings = kWhole;
  settings.distance_m = 1.6 / 1.01;  // what is measured is 1 % too far
  TargetMeter meter = MeterFor(settings);
  TargetNoise noise;
  meter.Add(noise.On(target.Disparity(TargetPair()), 0.1), {});
  const TargetQuality quality = meter.Quality();
  EXPECT_NEAR(*quality.plane_distance_m, 1.6, 0.0002);
  EXPECT_NEAR(*quality.distance_m, target.DepthAt(TargetPair(), 159.5, 119.5), 0.0002);
  ExpectNear(quality.tilt_horizontal_deg, 6);
  ExpectNear(quality.tilt_vertical_deg, -4);
  ExpectNear(quality.z_accuracy_percent, 1);
}

TEST(TargetMeter, HasTheNoiseThatWasPutIn) {
  TargetMeter meter = MeterFor(kWhole);
  TargetNoise noise;
  const cv::Mat1f flat = FlatTarget().Disparity(TargetPair());
  // As it travels, in counts of 1/32 px.
  for (int i = 0; i < 10; ++i) meter.Add(ToPx(FromPx(noise.On(flat, 0.1))), {});
  const TargetQuality quality = meter.Quality();
  const double depth_mm = DepthNoiseMm(TargetPair(), 1.5, 0.1);
  EXPECT_EQ(quality.frames, 10);
  ExpectNear(quality.subpixel_rms_px, 0.1);
  ExpectNear(quality.plane_rms_mm, depth_mm);
  ExpectNear(quality.plane_rms_percent, depth_mm / 15);
  ExpectNear(quality.temporal_noise_mm, depth_mm);
  ExpectNear(quality.temporal_noise_percent, depth_mm / 15);
  // 95 % of the standard deviations of 10 values lie below √(χ²(0.95; 9) / 9) = √(16.919 / 9).
  ExpectNear(quality.temporal_noise_95_mm, depth_mm * std::sqrt(16.919 / 9));
  EXPECT_EQ(quality.fill_rate_percent, 100);
  EXPECT_LT(*quality.outliers_percent, 0.05);
  EXPECT_EQ(quality.blinking_percent, 0);
  EXPECT_FALSE(quality.blinking_noise_mm);
}

TEST(TargetMeter, TellsWhatStandsStillFromWhatMoves) {
  TargetMeter meter = MeterFor(kWhole);
  TargetNoise noise;
  const cv::Mat1f pattern = noise.On(FlatTarget().Disparity(TargetPair()), 0.3);
  for (int i = 0; i < 10; ++i) meter.Add(noise.On(pattern, 0.05), {});
  const TargetQuality quality = meter.Quality();
  ExpectNear(quality.subpixel_rms_px, std::hypot(0.3, 0.05));
  ExpectNear(quality.temporal_noise_mm, DepthNoiseMm(TargetPair(), 1.5, 0.05));
}

TEST(TargetMeter, HoldsForTwoFramesAsForForty) {
  TargetNoise noise;
  const cv::Mat1f flat = FlatTarget().Disparity(TargetPair());
  for (const int frames : {2, 3, 40}) {
    TargetMeter meter = MeterFor(kWhole);
    for (int i = 0; i < frames; ++i) meter.Add(noise.On(flat, 0.1), {});
    ExpectNear(meter.Quality().temporal_noise_mm, DepthNoiseMm(TargetPair(), 1.5, 0.1));
  }
}

// Where pixels without a depth count as 0, or as pixels without noise, the median falls.
TEST(TargetMeter, HolesDoNotLowerTheNoise) {
  TargetMeter meter = MeterFor(kWhole);
  TargetNoise noise;
  cv::Mat1f flat = FlatTarget().Disparity(TargetPair());
  flat(cv::Rect(0, 0, 192, 240)) = kNoDisparity;  // 60 %
  const cv::Rect blinking(192, 0, 64, 240);       // 20 %, noisier than the rest
  for (int i = 0; i < 20; ++i) {
    cv::Mat1f map = noise.On(flat, 0.1);
    for (float& d : cv::Mat1f(map(blinking))) d += static_cast<float>(noise.Normal(0.3));
    if (i % 4 == 0) map(blinking) = kNoDisparity;
    meter.Add(map, {});
  }
  const TargetQuality quality = meter.Quality();
  ExpectNear(quality.temporal_noise_mm, DepthNoiseMm(TargetPair(), 1.5, 0.1));
  ExpectNear(quality.blinking_noise_mm, DepthNoiseMm(TargetPair(), 1.5, std::hypot(0.1, 0.3)));
  EXPECT_DOUBLE_EQ(*quality.never_valid_percent, 60);
  EXPECT_DOUBLE_EQ(*quality.blinking_percent, 20);
  EXPECT_DOUBLE_EQ(*quality.fill_rate_percent, 100 - 60 - 20 / 4.0);
}

// A board in front of the wall: least squares over all of it tilts the plane, and cutting the
// nearest and farthest depths off, as is done elsewhere, takes the ends of a tilted wall instead.
TEST(TargetMeter, OutliersAreFoundBeforeTheFit) {
  const FlatTarget target{.distance_m = 1.5, .horizontal_deg = 8, .vertical_deg = 0};
  TargetMeter meter = MeterFor(kWhole);
  TargetNoise noise;
  for (int i = 0; i < 3; ++i) {
    cv::Mat1f map = noise.On(target.Disparity(TargetPair()), 0.1);
    for (float& d : cv::Mat1f(map(cv::Rect(224, 0, 96, 200)))) d += 4;  // 25 %
    meter.Add(map, {});
  }
  const TargetQuality quality = meter.Quality();
  ExpectNear(quality.tilt_horizontal_deg, 8);
  EXPECT_NEAR(*quality.tilt_vertical_deg, 0, 0.05);
  EXPECT_NEAR(*quality.plane_distance_m, 1.5, 0.0003);
  ExpectNear(quality.outliers_percent, 25);
  ExpectNear(quality.subpixel_rms_px, 0.1);
}

TEST(TargetMeter, ScatteredOutliersAreCountedAndLeaveTheNoiseAlone) {
  TargetMeter meter = MeterFor(kWhole);
  TargetNoise noise;
  cv::Mat1f map = noise.On(FlatTarget().Disparity(TargetPair()), 0.1);
  for (float& d : map) {
    if (noise.Uniform() < 0.1) d += noise.Uniform() < 0.5 ? -5.0F : 8.0F;
  }
  meter.Add(map, {});
  const TargetQuality quality = meter.Quality();
  EXPECT_NEAR(*quality.outliers_percent, 10, 0.4);
  ExpectNear(quality.subpixel_rms_px, 0.1);
  ExpectNear(quality.plane_rms_mm, DepthNoiseMm(TargetPair(), 1.5, 0.1));
}

// In the corner of a wide-angle picture a ray is 1.6 times as long as its depth.
TEST(TargetMeter, ResidualsAreAlongTheOpticalAxisAndNotAlongTheRay) {
  RectifiedPair pair = TargetPair();
  pair.focal_px = 150;
  pair.cx = pair.cx_right = 0;
  pair.cy = 0;
  TargetMeter meter = MeterFor({.region = cv::Rect(160, 80, 160, 160)}, pair);
  TargetNoise noise;
  cv::Mat1f depth_noise(pair.size());
  const double deviation_m = 0.002;
  for (int i = 0; i < 5; ++i) {
    cv::Mat1f map(pair.size());
    for (float& d : map) {
      d = static_cast<float>(pair.DisparityFromDepth(1.5 + noise.Normal(deviation_m)));
    }
    meter.Add(map, {});
  }
  const TargetQuality quality = meter.Quality();
  ExpectNear(quality.plane_rms_mm, 1000 * deviation_m);
  ExpectNear(quality.temporal_noise_mm, 1000 * deviation_m);
  ExpectNear(quality.subpixel_rms_px, 150 * 0.15 / (1.5 * 1.5) * deviation_m);
}

TEST(TargetMeter, SaysWhetherTheSigmaOfTheMapIsHonest) {
  TargetNoise noise;
  const cv::Mat1f flat = FlatTarget().Disparity(TargetPair());
  for (const double claimed : {0.25, 0.5, 1.0}) {
    TargetMeter meter = MeterFor(kWhole);
    for (int i = 0; i < 3; ++i) {
      meter.Add(noise.On(flat, 0.5), cv::Mat1b(flat.size(), SigmaToCounts(claimed)));
    }
    const TargetQuality quality = meter.Quality();
    ExpectNear(quality.sigma_claimed_px, claimed);
    ExpectNear(quality.sigma_ratio, claimed / 0.5);
    ExpectNear(quality.within_1_sigma_percent, 100 * std::erf(claimed / 0.5 / std::sqrt(2)));
    ExpectNear(quality.within_2_sigma_percent, 100 * std::erf(2 * claimed / 0.5 / std::sqrt(2)));
  }
}

TEST(TargetMeter, AnOutlierIsOutsideOfItsSigma) {
  TargetMeter meter = MeterFor(kWhole);
  TargetNoise noise;
  cv::Mat1f map = noise.On(FlatTarget().Disparity(TargetPair()), 0.5);
  map(cv::Rect(0, 0, 32, 240)) += 20.0F;  // 10 %
  meter.Add(map, cv::Mat1b(map.size(), SigmaToCounts(0.5)));
  const TargetQuality quality = meter.Quality();
  ExpectNear(quality.sigma_ratio, 1);
  ExpectNear(quality.within_2_sigma_percent, 0.9 * 95.45);
}

TEST(TargetMeter, WithoutASigmaThereIsNoneOfItsFigures) {
  TargetMeter meter = MeterFor(kWhole);
  meter.Add(FlatTarget().Disparity(TargetPair()), {});
  const TargetQuality quality = meter.Quality();
  EXPECT_FALSE(quality.sigma_claimed_px);
  EXPECT_FALSE(quality.sigma_ratio);
  EXPECT_FALSE(quality.within_1_sigma_percent);
  EXPECT_FALSE(quality.z_accuracy_percent);  // no true distance
  EXPECT_FALSE(quality.temporal_noise_mm);   // one frame
  EXPECT_FALSE(quality.blinking_percent);
  EXPECT_FALSE(quality.edge_width_px);
}

TEST(TargetMeter, LooksAtTheRegionOnlyByDefaultTheMiddle) {
  TargetMeter meter = MeterFor({});
  EXPECT_EQ(meter.region(), cv::Rect(80, 60, 160, 120));
  cv::Mat1f map(TargetPair().size(), kNoDisparity);
  FlatTarget().Disparity(TargetPair())(meter.region()).copyTo(map(meter.region()));
  meter.Add(map, {});
  EXPECT_EQ(meter.Quality().fill_rate_percent, 100);
  EXPECT_NEAR(*meter.Quality().plane_distance_m, 1.5, 1e-5);
}

TEST(TargetMeter, MeasuresTheNewestFrames) {
  TargetSettings settings = kWhole;
  settings.count = 3;
  TargetMeter meter = MeterFor(settings);
  for (const double distance_m : {1.0, 1.0, 2.0, 2.0, 2.0}) {
    meter.Add(FlatTarget{.distance_m = distance_m}.Disparity(TargetPair()), {});
  }
  EXPECT_EQ(meter.Quality().frames, 3);
  EXPECT_NEAR(*meter.Quality().distance_m, 2, 1e-4);
}

TEST(TargetMeter, MapsShowWhereTheWallIsNotFlat) {
  TargetMeter meter = MeterFor(kWhole);
  TargetNoise noise;
  cv::Mat1f bent = FlatTarget().Disparity(TargetPair());
  bent(cv::Rect(0, 0, 20, 20)) += 0.2F;
  bent(cv::Rect(100, 100, 20, 20)) = kNoDisparity;
  for (int i = 0; i < 10; ++i) meter.Add(noise.On(bent, 0.1), {});
  const TargetMaps maps = meter.Maps();
  EXPECT_NEAR(cv::mean(maps.residual_mm(cv::Rect(0, 0, 20, 20)))[0],
              -DepthNoiseMm(TargetPair(), 1.5, 0.2), 0.3);
  EXPECT_NEAR(cv::mean(maps.residual_mm(cv::Rect(200, 20, 20, 20)))[0], 0, 0.3);
  EXPECT_NEAR(cv::mean(maps.noise_mm(cv::Rect(200, 20, 20, 20)))[0],
              DepthNoiseMm(TargetPair(), 1.5, 0.1), 0.1);
  EXPECT_TRUE(std::isnan(maps.residual_mm(110, 110)));
  EXPECT_TRUE(std::isnan(maps.noise_mm(110, 110)));
}

TEST(TargetMeter, HasNoFiguresWithoutFramesAndNoPlaneWithoutPixels) {
  TargetMeter meter = MeterFor(kWhole);
  for (const TargetFigure& figure : TargetFigures()) {
    EXPECT_FALSE(meter.Quality().*figure.value) << figure.name;
  }
  meter.Add(cv::Mat1f(TargetPair().size(), kNoDisparity), {});
  // At infinity and behind: no depths.
  meter.Add(cv::Mat1f(TargetPair().size(), 3.0F), {});
  meter.Add(cv::Mat1f(TargetPair().size(), -20.0F), {});
  const TargetQuality quality = meter.Quality();
  EXPECT_EQ(quality.frames, 3);
  EXPECT_EQ(quality.without_plane, 3);
  EXPECT_EQ(quality.fill_rate_percent, 0);
  EXPECT_EQ(quality.never_valid_percent, 100);
  EXPECT_FALSE(quality.distance_m);
  EXPECT_FALSE(quality.plane_rms_mm);
  EXPECT_FALSE(quality.temporal_noise_mm);
}

TEST(TargetMeter, RefusesRegionsAndCalibrationsThatDoNotFit) {
  const RectifiedPair pair = TargetPair();
  const auto why = [&](const cv::Rect& region) {
    const auto meter = TargetMeter::For({.region = region}, pair, pair.size());
    return meter ? std::string() : meter.error().text;
  };
  EXPECT_EQ(why({0, 0, 320, 240}), "");
  for (const cv::Rect region :
       {cv::Rect(1, 0, 320, 240), cv::Rect(0, 1, 320, 240), cv::Rect(-1, 0, 20, 20),
        cv::Rect(0, 0, 7, 20), cv::Rect(0, 0, 20, 7), cv::Rect(2147483647, 0, 2147483647, 20)}) {
    EXPECT_THAT(why(region), HasSubstr("allowed is a rectangle")) << region;
  }
  EXPECT_THAT(TargetMeter::For({.edge = cv::Rect(0, 0, 4, 4)}, pair, pair.size()).error().text,
              HasSubstr("edge 0,0,4,4: allowed"));
  EXPECT_THAT(TargetMeter::For({}, pair, {640, 480}).error().text,
              HasSubstr("the calibration is of 320x240 px, the map of 640x480"));
  EXPECT_THAT(
      TargetMeter::For({}, {.width = 8, .height = 8, .focal_px = 9, .baseline_m = 1}, {8, 8})
          .error()
          .text,
      HasSubstr("region 2,2,4,4"));
}

}  // namespace
}  // namespace sprout
