#include "common/scenes/zone_sensor.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "tests/common/config/with.h"
#include "tests/common/testing/thrown.h"

namespace sprout::scenes {
namespace {

constexpr int kZoneSide = 16;  // samples of a zone, along either side

RectifiedPair ZonesPair() {
  return {.width = 640,
          .height = 480,
          .focal_px = 800,
          .cx = 300,
          .cy = 250,
          .cx_right = 310,
          .baseline_m = 0.12};
}

// Two zones beside each other, without noise.
const std::string kTwoZones = "columns: 2 rows: 1 depth_noise_percent: 0 ";

// A wall that fills the view of both.
TofSamples ZonesWall(float depth_m, float albedo = 0.5F) {
  TofSamples samples({8, 4});
  samples.depth_m = depth_m;
  samples.albedo = albedo;
  return samples;
}

// The first rows of the first zone, sixteenths of it.
void SetZoneTop(TofSamples& samples, int sixteenths, float depth_m, float albedo = 0.5F) {
  const cv::Rect top(0, 0, kZoneSide, sixteenths);
  samples.depth_m(top) = depth_m;
  samples.albedo(top) = albedo;
}

TofZones MeasureZones(const TofSamples& samples, const std::string& config = kTwoZones,
                      int64_t frame = 0) {
  return ZoneSensor(ZonesPair(), With<ZonesConfig>(config), 1).Measure(samples, frame);
}

TEST(ZoneSensor, LooksALittleBeyondTheLeftImageFromBetweenTheCameras) {
  const TofZones zones = MeasureZones(ZonesWall(2));
  ASSERT_EQ(zones.views.size(), 2);
  EXPECT_EQ(zones.left_from_sensor.translation_m, Eigen::Vector3d(0.06, -0.02, 0));
  EXPECT_FLOAT_EQ(zones.views[0].right, zones.views[1].left);
  EXPECT_EQ(zones.views[0].top, zones.views[1].top);
  // 1.15 times as wide and as high as the image, 0.8 and 0.6 of the focal length.
  EXPECT_NEAR(zones.views[1].right - zones.views[0].left, 1.15 * 0.8, 1e-6);
  EXPECT_NEAR(zones.views[0].bottom - zones.views[0].top, 1.15 * 0.6, 1e-6);
  // At a disparity of 8 % of the width, 51.2 px, z = 800 · 0.12 / 61.2 = 1.5686 m, the image's
  // middle (319.5, 239.5) is between the zones.
  EXPECT_NEAR(zones.views[0].right, (19.5 / 800) - 0.06 / 1.568627, 1e-6);
  EXPECT_NEAR((zones.views[0].top + zones.views[0].bottom) / 2, -10.5 / 800 + 0.02 / 1.568627,
              1e-6);
}

TEST(ZoneSensor, ReportsTheMeanOfASurfaceAndHowFarItSpreads) {
  TofSamples samples = ZonesWall(2);
  // Light a quarter as strong a metre and a half nearer: 0.4 m between them, one target.
  SetZoneTop(samples, 4, 1.6F, 0.5F * 0.64F);  // the same light from each sample
  const TofZones zones = MeasureZones(samples);
  const auto first = zones.TargetsOf(0);
  EXPECT_EQ(first[0].status, TargetStatus::kValid);
  EXPECT_NEAR(first[0].depth_m, 0.25 * 1.6 + 0.75 * 2, 1e-6);
  EXPECT_NEAR(first[0].sigma_m, 0.4 * std::sqrt(0.25 * 0.75), 1e-6);
  EXPECT_EQ(first[1].status, TargetStatus::kNone);
  EXPECT_NEAR(zones.TargetsOf(1)[0].depth_m, 2, 1e-6);
  EXPECT_NEAR(zones.TargetsOf(1)[0].sigma_m, 1e-4, 1e-6) << "never 0";
}

TEST(ZoneSensor, TellsTargetsApartFromTheirSeparationOn) {
  TofSamples samples = ZonesWall(2);
  SetZoneTop(samples, 4, 1.35F, 0.5F * 1.35F * 1.35F / 4);
  const TofZones two = MeasureZones(samples);
  EXPECT_NEAR(two.TargetsOf(0)[0].depth_m, 2, 1e-6) << "the strongest first";
  EXPECT_NEAR(two.TargetsOf(0)[1].depth_m, 1.35, 1e-6);
  EXPECT_NEAR(two.TargetsOf(0)[1].sigma_m, 1e-4, 1e-6);
  EXPECT_EQ(MeasureZones(samples, kTwoZones + "targets: 1").TargetsOf(0).size(), 1);
  const TofZones one = MeasureZones(samples, kTwoZones + "targets: 2 separation_m: 0.7");
  EXPECT_EQ(one.TargetsOf(0)[1].status, TargetStatus::kNone);
}

TEST(ZoneSensor, ReportsInModeNearestWhereTheLightBegins) {
  const std::string config = kTwoZones + "mode: NEAREST";
  TofSamples samples = ZonesWall(2);
  SetZoneTop(samples, 1, 1.5F, 0.5F * 1.5F * 1.5F / 4);  // 6 % of the light
  TofZones zones = MeasureZones(samples, config);
  EXPECT_EQ(zones.mode, ZoneMode::kNearest);
  EXPECT_NEAR(zones.TargetsOf(0)[0].depth_m, 1.5, 1e-6);
  EXPECT_NEAR(zones.TargetsOf(0)[0].sigma_m, 1e-4, 1e-6) << "of the nearest depth alone";
  SetZoneTop(samples, 1, 1.5F, 0.25F * 1.5F * 1.5F / 4);  // 3 %
  EXPECT_NEAR(MeasureZones(samples, config).TargetsOf(0)[0].depth_m, 2, 1e-6);
  // Two targets: the nearest first, however weak.
  samples = ZonesWall(4);
  SetZoneTop(samples, 2, 1, 0.02F);  // 8 % of the light of the other zone
  zones = MeasureZones(samples, config);
  EXPECT_NEAR(zones.TargetsOf(0)[0].depth_m, 1, 1e-6);
  EXPECT_NEAR(zones.TargetsOf(0)[1].depth_m, 4, 1e-6);
}

TEST(ZoneSensor, HasNoTargetWhereTheLightIsWeakOrUnknown) {
  TofSamples samples = ZonesWall(2);
  SetZoneTop(samples, kZoneSide, 2, 0.5F * 0.049F);
  // The median of two is the larger one.
  EXPECT_EQ(MeasureZones(samples).TargetsOf(0)[0].status, TargetStatus::kNone);
  SetZoneTop(samples, kZoneSide, 2, 0.5F * 0.051F);
  EXPECT_EQ(MeasureZones(samples).TargetsOf(0)[0].status, TargetStatus::kDoubtful);
  SetZoneTop(samples, kZoneSide, 2, 0.5F * 0.101F);
  EXPECT_EQ(MeasureZones(samples).TargetsOf(0)[0].status, TargetStatus::kValid);
  samples = ZonesWall(2);
  samples.depth_m(cv::Rect(0, 0, kZoneSide, 8)) = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(MeasureZones(samples).TargetsOf(0)[0].status, TargetStatus::kValid) << "half is enough";
  samples.depth_m(8, 0) = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(MeasureZones(samples).TargetsOf(0)[0].status, TargetStatus::kNone);
  samples.depth_m = std::numeric_limits<float>::quiet_NaN();
  for (const ZoneTarget& target : MeasureZones(samples).targets) EXPECT_EQ(target, ZoneTarget());
}

TEST(ZoneSensor, HasTheStatedNoiseAndSaysSo) {
  const std::string config = "columns: 64 rows: 64 depth_noise_percent: 2";
  TofSamples samples(cv::Size(64, 64) * 4);
  samples.depth_m = 3;
  samples.albedo = 0.5F;
  const TofZones zones = MeasureZones(samples, config);
  double squares = 0;
  for (size_t i = 0; i < zones.views.size(); ++i) {
    squares += std::pow(zones.TargetsOf(i)[0].depth_m - 3, 2);
    ASSERT_NEAR(zones.TargetsOf(i)[0].sigma_m, 0.06, 1e-6);
  }
  // 4096 values: their standard deviation is known to 1.1 %.
  EXPECT_NEAR(std::sqrt(squares / 4096), 0.06, 0.06 * 0.05);
  EXPECT_EQ(zones, MeasureZones(samples, config)) << "the same frame again";
  EXPECT_NE(zones, MeasureZones(samples, config, 1)) << "another frame";
}

TEST(ZoneSensor, RefusesValuesOutOfRange) {
  EXPECT_THAT(Thrown<ConfigError>([&] { MeasureZones(ZonesWall(2), "columns: 65"); }),
              testing::HasSubstr("capture.zones.columns = 65"));
}

}  // namespace
}  // namespace sprout::scenes
