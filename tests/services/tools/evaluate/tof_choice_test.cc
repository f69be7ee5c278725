#include <gmock/gmock.h>

#include "services/tools/evaluate/scene.h"
#include "tests/common/testing/thrown.h"

namespace sprout::evaluate {
namespace {

int Spacing(const std::string& text, int rows) {
  CaptureConfig config;
  TofChoice(text).Apply(rows, config);
  return config.tof_grid_px();
}

TEST(TofChoice, FollowsTheRowsOfTheImage) {
  EXPECT_EQ(Spacing("grid:auto", 1110), 10);
  EXPECT_EQ(Spacing("grid:auto", 555), 5);
  EXPECT_EQ(Spacing("grid:auto", 370), 3);
  EXPECT_EQ(Spacing("grid:auto", 500), 5);
  EXPECT_EQ(Spacing("grid:auto", 40), 1);
}

TEST(TofChoice, MultipliesTheAutomaticSpacing) {
  EXPECT_EQ(Spacing("grid:auto*2", 1110), 20);
  EXPECT_EQ(Spacing("grid:auto*1.5", 555), 8);
  EXPECT_EQ(Spacing("grid:auto*0.001", 555), 1);
}

TEST(TofChoice, TakesASpacingAsItIs) { EXPECT_EQ(Spacing("grid:7", 1110), 7); }

TEST(TofChoice, ChoosesTheCamera) {
  CaptureConfig config;
  TofChoice("sr4000").Apply(1110, config);
  EXPECT_EQ(config.tof(), "sr4000");
  TofChoice("none").Apply(1110, config);
  EXPECT_EQ(config.tof(), "none");
  TofChoice("grid:7").Apply(1110, config);
  EXPECT_EQ(config.tof(), "grid");
}

TEST(TofChoice, TakesTheFaultsOfTheCamera) {
  CaptureConfig config;
  config.mutable_sr4000()->set_depth_noise_m(0.01);
  TofChoice("sr4000?blind=50&wrapped=12.5&calibration=3").Apply(1110, config);
  EXPECT_EQ(config.tof(), "sr4000");
  EXPECT_EQ(config.sr4000().blind_percent(), 50);
  EXPECT_EQ(config.sr4000().wrapped_percent(), 12.5);
  EXPECT_EQ(config.sr4000().calibration_error_px(), 3);
  EXPECT_EQ(config.sr4000().depth_noise_m(), 0.01);  // what it does not name stays
}

TEST(TofChoice, TakesErrorsOfRangeForAnySensor) {
  for (const char* sensor : {"grid:auto", "grid:auto*2", "grid:10", "sr4000"}) {
    CaptureConfig config;
    TofChoice(std::string(sensor) + "?range=-20&wiggle=10&period=0.6&bumps=3&mirrored&unit=1000")
        .Apply(1110, config);
    EXPECT_EQ(config.tof(), std::string(sensor).substr(0, std::string(sensor).find(':')));
    EXPECT_EQ(config.range_errors().offset_m(), -0.02);
    EXPECT_EQ(config.range_errors().wiggle_m(), 0.01);
    EXPECT_EQ(config.range_errors().wiggle_period_m(), 0.6);
    EXPECT_EQ(config.range_errors().bumps_px(), 3);
    EXPECT_EQ(config.range_errors().unit(), 1000);
    EXPECT_TRUE(config.range_errors().mirrored());
  }
  EXPECT_EQ(Spacing("grid:auto*2?range=10", 1110), 20);
  for (const char* text : {"grid:10?", "grid:10?range", "grid:auto?blind=5", "none?range=5",
                           "zones:8x8?range=5", "scan?range=0.2", "grid:10?yaw=1"}) {
    EXPECT_THROW(TofChoice choice(text), ConfigError) << text;
  }
}

TEST(TofChoice, TakesAMultiZoneSensor) {
  CaptureConfig config;
  config.mutable_zones()->set_depth_noise_percent(3);
  TofChoice("zones:16x12?mode=nearest&targets=1").Apply(1110, config);
  EXPECT_EQ(config.tof(), "zones");
  EXPECT_EQ(config.zones().columns(), 16);
  EXPECT_EQ(config.zones().rows(), 12);
  EXPECT_EQ(config.zones().mode(), ZonesConfig::NEAREST);
  EXPECT_EQ(config.zones().targets(), 1);
  EXPECT_EQ(config.zones().depth_noise_percent(), 3);  // what it does not name stays
  for (const char* text : {"zones:8", "zones:8x8?", "zones:8x8?mode=", "zones:8x8?blind=5",
                           "zones:65x8", "zones:8x8?targets=0"}) {
    EXPECT_THROW(TofChoice choice(text), ConfigError) << text;
  }
}

TEST(TofChoice, RefusesWhatItDoesNotKnow) {
  for (const char* text :
       {"", "grid", "grid:", "grid:0", "grid:-3", "grid:1001", "grid:5x", "grid:auto*",
        "grid:auto*0", "grid:auto*nan", "grid:auto*1000", "grid:automatic", "sr4001", "lidar"}) {
    EXPECT_THAT(Thrown<ConfigError>([&] { TofChoice choice(text); }),
                testing::AllOf(testing::HasSubstr("--tof " + std::string(text)),
                               testing::HasSubstr("grid:auto*K")));
  }
}

}  // namespace
}  // namespace sprout::evaluate
