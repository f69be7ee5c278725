#include <gmock/gmock.h>

#include <cmath>

#include "tests/common/scenes/scene_folder.h"

namespace sprout::scenes {
namespace {

using testing::AllOf;
using testing::HasSubstr;

CaptureConfig WithSource(const std::string& source) {
  CaptureConfig config;
  config.set_source(source);
  return config;
}

TEST(OpenDataset, OpensTheDefaultConfiguration) {
  const auto source = OpenDataset(CaptureConfig());
  EXPECT_EQ(source->rig().pair.size(), cv::Size(640, 480));
}

TEST(OpenDataset, NamesTheSourcesThatExist) {
  for (const std::string text : {"", "webcam:0", "synthetic640x480", ":"}) {
    EXPECT_THAT(OpenError(WithSource(text)),
                AllOf(HasSubstr("capture.source = " + text + ": "), HasSubstr("middlebury:DIR"),
                      HasSubstr("synthetic:WxH")));
  }
}

TEST(OpenDataset, SaysWhoPlaysLogs) {
  EXPECT_THAT(OpenError(WithSource("log:run.lcm")), HasSubstr("only sprout-capture plays logs"));
}

TEST(OpenDataset, RefusesAFolderThatDoesNotExist) {
  for (const std::string text : {"middlebury", "middlebury:", "middlebury:/no/such/folder"}) {
    EXPECT_THAT(OpenError(WithSource(text)),
                AllOf(HasSubstr("capture.source = middlebury:"), HasSubstr("no such folder;"),
                      HasSubstr("allowed: ")));
  }
}

TEST(OpenDataset, RefusesATextThatIsNoSize) {
  for (const std::string size : {"", "640", "x", "640x", "x480", "640x480x3", "640 x480", "6e2x480",
                                 "+640x480", "99999999999x480"}) {
    EXPECT_THAT(OpenError(WithSource("synthetic:" + size)),
                AllOf(HasSubstr("capture.source = synthetic:" + size + ": "), HasSubstr("size"),
                      HasSubstr("allowed: synthetic:WxH with 16 to 16384 px")));
  }
}

TEST(OpenDataset, RefusesASizeOutOfRange) {
  for (const std::string size : {"15x480", "640x15", "16385x480", "640x16385", "-640x480", "0x0"}) {
    EXPECT_THAT(OpenError(WithSource("synthetic:" + size)),
                AllOf(HasSubstr("size out of range"), HasSubstr("16 to 16384 px a side")));
  }
}

TEST(OpenDataset, ChecksTheRangesOfTheConfiguration) {
  CaptureConfig config = WithSource("synthetic:64x48");
  config.set_tof_grid_px(0);
  EXPECT_THAT(OpenError(config), HasSubstr("capture.tof_grid_px = 0"));
}

TEST(OpenDataset, TakesTheTofCameraFromTheConfigurationOrTheSource) {
  CaptureConfig config = WithSource("synthetic:64x48");
  EXPECT_EQ(OpenDataset(config)->rig().tof.width, 6);
  config.set_tof("sr4000");
  EXPECT_EQ(OpenDataset(config)->rig().tof.width, 176);
  config.set_source("synthetic:64x48?tof=grid");
  EXPECT_EQ(OpenDataset(config)->rig().tof.width, 6);
  config.set_tof("grid");
  config.set_source("synthetic:64x48?tof=sr4000");
  EXPECT_EQ(OpenDataset(config)->rig().tof.width, 176);
}

TEST(OpenDataset, TakesTheFaultsOfTheSr4000FromTheSource) {
  const auto returns = [](const std::string& options) {
    const TofImage tof = OpenDataset(WithSource("synthetic:64x48" + options))->Get(0).tof;
    return cv::countNonZero(tof.depth_m == tof.depth_m);
  };
  const int all = returns("?tof=sr4000");
  EXPECT_EQ(returns("?tof=sr4000&blind=50"), all - std::lround(all / 2.0));
  EXPECT_LT(returns("?tof=sr4000&every=4"), all / 12);
  EXPECT_THAT(OpenError(WithSource("synthetic:64x48?tof=sr4000&every=0.5")),
              HasSubstr("capture.sr4000.every_px = 0.5"));
  EXPECT_THAT(OpenError(WithSource("synthetic:64x48?tof=sr4000&blind=120")),
              HasSubstr("capture.sr4000.blind_percent = 120"));
  EXPECT_THAT(OpenError(WithSource("synthetic:64x48?tof=sr4000&blind=x")),
              HasSubstr("sr4000?blind=x: not a number"));
  EXPECT_THAT(OpenError(WithSource("synthetic:64x48?blind=50")),
              HasSubstr("no such option blind=50"));
}

TEST(OpenDataset, TakesAMultiZoneSensorFromTheConfigurationOrTheSource) {
  CaptureConfig config = WithSource("synthetic:64x48");
  config.set_tof("zones:16x12");
  DatasetFrame frame = OpenDataset(config)->Get(0);
  ASSERT_TRUE(frame.tof_zones);
  EXPECT_EQ(frame.tof_zones->columns, 16);
  EXPECT_EQ(frame.tof_zones->rows, 12);
  EXPECT_EQ(frame.tof_zones->targets_per_zone, 2);
  EXPECT_TRUE(frame.tof.depth_m.empty());
  EXPECT_EQ(OpenDataset(config)->rig().tof.width, 0);
  const SceneFolder folder(cv::Size(40, 30));
  for (const std::string& source : {folder.Config().source(), std::string("synthetic:64x48")}) {
    const auto opened = OpenDataset(WithSource(source + "?tof=zones:4x3&mode=nearest&targets=1"));
    frame = opened->Get(0);
    ASSERT_TRUE(frame.tof_zones) << source;
    EXPECT_EQ(frame.tof_zones->views.size(), 12);
    EXPECT_EQ(frame.tof_zones->targets.size(), 12);
    EXPECT_EQ(frame.tof_zones->mode, ZoneMode::kNearest);
    EXPECT_EQ(frame.tof_zones, opened->Get(0).tof_zones) << "the same frame again";
  }
  EXPECT_FALSE(OpenDataset(WithSource("synthetic:64x48?tof=grid"))->Get(0).tof_zones);
}

TEST(OpenDataset, RefusesZonesThatCannotBe) {
  for (const std::string size :
       {"zones:", "zones:8", "zones:8x", "zones:x8", "zones8x8", "zones:8x8x8"}) {
    EXPECT_THAT(OpenError(WithSource("synthetic:64x48?tof=" + size)),
                HasSubstr("capture.tof = " + size + ": no size; allowed: zones:CxR"));
  }
  EXPECT_THAT(OpenError(WithSource("synthetic:64x48?tof=zones:0x8")),
              HasSubstr("capture.zones.columns = 0"));
  EXPECT_THAT(OpenError(WithSource("synthetic:64x48?tof=zones:8x65")),
              HasSubstr("capture.zones.rows = 65"));
  EXPECT_THAT(OpenError(WithSource("synthetic:64x48?tof=zones:8x8&mode=first")),
              HasSubstr("zones?mode=first: no such value"));
  EXPECT_THAT(OpenError(WithSource("synthetic:64x48?tof=zones:8x8&targets=5")),
              HasSubstr("capture.zones.targets = 5"));
  EXPECT_THAT(OpenError(WithSource("synthetic:64x48?tof=zones:8x8&blind=5")),
              HasSubstr("no such option blind=5"));
  EXPECT_THAT(OpenError(WithSource("synthetic:64x48?tof=grid&mode=mean")),
              HasSubstr("no such option mode=mean"));
}

TEST(OpenDataset, OpensScenesWithoutATofCamera) {
  const SceneFolder folder(cv::Size(40, 30));
  for (const std::string& source : {folder.Config().source(), std::string("synthetic:64x48")}) {
    const auto opened = OpenDataset(WithSource(source + "?tof=none"));
    EXPECT_EQ(opened->rig().tof.width, 0);
    EXPECT_EQ(opened->rig().tof.height, 0);
    EXPECT_TRUE(opened->Get(0).tof.depth_m.empty());
  }
}

TEST(OpenDataset, NamesTheTofCamerasThatExist) {
  CaptureConfig config = WithSource("synthetic:64x48");
  config.set_tof("kinect");
  EXPECT_THAT(OpenError(config), AllOf(HasSubstr("capture.tof = kinect: "),
                                       HasSubstr("allowed: grid, sr4000, zones:CxR, none")));
  for (const std::string option :
       {"", "tof", "tof=", "tof=kinect", "tof=sr4000&x=1", "tof=grid&"}) {
    EXPECT_THAT(OpenError(WithSource("synthetic:64x48?" + option)),
                AllOf(HasSubstr("allowed: "), HasSubstr("sr4000")));
  }
  EXPECT_THAT(OpenError(WithSource("synthetic:64x48?tof=grid&tof=none")),
              HasSubstr("tof=grid and tof=none: allowed is each option once"));
  EXPECT_THAT(OpenError(WithSource("middlebury:/no/folder?zoom=2")),
              AllOf(HasSubstr("no such option zoom=2"), HasSubstr("?tof=sr4000")));
}

TEST(OpenDataset, ChecksTheRangesOfTheSr4000) {
  CaptureConfig config = WithSource("synthetic:64x48");
  config.mutable_sr4000()->set_view_margin(0);
  EXPECT_THAT(OpenError(config), HasSubstr("capture.sr4000.view_margin = 0"));
}

TEST(OpenDataset, NamesTheRangeWhenTheTofGridIsWiderThanTheImage) {
  CaptureConfig config = WithSource("synthetic:64x48");
  config.set_tof_grid_px(49);
  EXPECT_THAT(OpenError(config), AllOf(HasSubstr("capture.tof_grid_px = 49"), HasSubstr("64x48"),
                                       HasSubstr("allowed: 1 to 48")));
  config.set_tof_grid_px(48);
  EXPECT_EQ(OpenDataset(config)->rig().tof.width, 1);
}

}  // namespace
}  // namespace sprout::scenes
