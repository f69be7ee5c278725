
#include <gmock/gmock.h>

#include <cmath>

#include "common/geometry/projection.h"
#include "common/scenes/stray_light.h"
#include "tests/common/scenes/kitti_folder.h"
#include "tests/common/scenes/scene_folder.h"

namespace sprout::scenes {
namespace {

using testing::HasSubstr;

TofImage TofOf(const std::string& source) { return OpenDataset(source)->Get(0).tof; }

// Length of the ray to a pixel of the grid at depth 1.
double RayLength(const TofCamera& tof, int u, int v) {
  return std::sqrt(1 + std::pow((u - tof.cx) / tof.fx, 2) + std::pow((v - tof.cy) / tof.fy, 2));
}

TEST(Phasor, IsCosineAndSine) {
  for (double turns = -3; turns < 3; turns += 0.0137) {
    EXPECT_NEAR(UnitPhasor(turns).real(), std::cos(2 * M_PI * turns), 1e-11) << turns;
    EXPECT_NEAR(UnitPhasor(turns).imag(), std::sin(2 * M_PI * turns), 1e-11) << turns;
  }
}

TEST(RangeErrors, AddsMillimetresAlongTheRayOfGridAndSr4000) {
  for (const std::string source : {"synthetic:64x48?tof=grid", "synthetic:64x48?tof=sr4000"}) {
    const auto right = OpenDataset(source);
    const TofImage before = right->Get(0).tof;
    const TofImage after = TofOf(source + "&range=-20");
    const TofCamera& tof = right->rig().tof;
    int compared = 0;
    for (int v = 0; v < before.depth_m.rows; ++v) {
      for (int u = 0; u < before.depth_m.cols; ++u) {
        ASSERT_EQ(std::isnan(before.depth_m(v, u)), std::isnan(after.depth_m(v, u)));
        if (std::isnan(before.depth_m(v, u))) continue;
        const double change_m = after.depth_m(v, u) - before.depth_m(v, u);
        // The SR4000's lens is distorted by a few pixels of 176.
        EXPECT_NEAR(change_m * RayLength(tof, u, v), -0.02, source.ends_with("grid") ? 2e-6 : 1e-3);
        ++compared;
      }
    }
    EXPECT_GT(compared, 15);
    EXPECT_EQ(cv::norm(before.amplitude, after.amplitude), 0);
  }
}

TEST(RangeErrors, WigglesAsASineOfTheRange) {
  const auto right = OpenDataset("synthetic:640x480?tof=grid");
  const TofImage before = right->Get(0).tof;
  for (const auto& [period, period_m] : {std::pair{"", 1.25}, {"&period=0.6", 0.6}}) {
    const TofImage after = TofOf("synthetic:640x480?tof=grid&wiggle=10" + std::string(period));
    double largest = 0;
    for (int v = 0; v < before.depth_m.rows; ++v) {
      for (int u = 0; u < before.depth_m.cols; ++u) {
        const double length = RayLength(right->rig().tof, u, v);
        const double range_m = before.depth_m(v, u) * length;
        const double off_m = after.depth_m(v, u) * length - range_m;
        ASSERT_NEAR(off_m, 0.01 * std::sin(2 * M_PI * range_m / period_m), 2e-6);
        largest = std::max(largest, std::abs(off_m));
      }
    }
    EXPECT_GT(largest, 0.009);
  }
}

TEST(RangeErrors, HasSixSmoothBumpsOfSoManyPixelsWhichAreTooFar) {
  const auto right = OpenDataset("synthetic:640x480?tof=grid");
  const RectifiedPair& pair = right->rig().pair;
  const TofImage before = right->Get(0).tof;
  const TofImage after = TofOf("synthetic:640x480?tof=grid&bumps=3");
  cv::Mat1d less(before.depth_m.size());
  for (int i = 0; i < static_cast<int>(less.total()); ++i) {
    less(i) =
        pair.DisparityFromDepth(before.depth_m(i)) - pair.DisparityFromDepth(after.depth_m(i));
  }
  double least = 0;
  double most = 0;
  cv::minMaxLoc(less, &least, &most);
  EXPECT_GT(least, -1e-4);
  EXPECT_GT(most, 2.5);    // a grid point is near a middle,
  EXPECT_LT(most, 3 * 3);  // and bumps may overlap
  const double volume = cv::mean(less)[0];
  // π R²/4 of each bump's cylinder, R = 0.233 of the height; some of it is outside of the image.
  const double whole = 6 * 3 * M_PI / 4 * std::pow(2.59 * 0.09, 2) * 480 / 640;
  EXPECT_LT(volume, whole);
  EXPECT_GT(volume, 0.6 * whole);
  cv::Mat1d steps;
  cv::absdiff(less.colRange(1, less.cols), less.colRange(0, less.cols - 1), steps);
  cv::minMaxLoc(steps, nullptr, &most);
  EXPECT_LT(most, 1);  // no step
}

TEST(RangeErrors, PlacesBumpsBySeed) {
  CaptureConfig config;
  config.set_source("synthetic:64x48?tof=grid&bumps=3");
  const TofImage one = OpenDataset(config)->Get(0).tof;
  EXPECT_EQ(cv::norm(one.depth_m, OpenDataset(config)->Get(0).tof.depth_m), 0);
  const SceneFolder folder(cv::Size(40, 30));
  CaptureConfig scene = folder.Config();
  scene.set_source(scene.source() + "?bumps=3");
  const cv::Mat1f first = OpenDataset(scene)->Get(0).tof.depth_m;
  scene.set_seed(2);
  EXPECT_GT(cv::countNonZero(first != OpenDataset(scene)->Get(0).tof.depth_m), 10);
}

TEST(RangeErrors, MirrorsAndTakesAnotherUnit) {
  const TofImage before = TofOf("synthetic:64x48?tof=grid");
  const TofImage mirrored = TofOf("synthetic:64x48?tof=grid&mirrored");
  const TofImage mm = TofOf("synthetic:64x48?tof=grid&unit=1000");
  const int last = before.depth_m.cols - 1;
  for (int u = 0; u <= last; ++u) {
    EXPECT_FLOAT_EQ(mirrored.depth_m(2, u), before.depth_m(2, last - u));
    EXPECT_FLOAT_EQ(mm.depth_m(2, u), 1000 * before.depth_m(2, u));
  }
  const TofImage camera = TofOf("synthetic:64x48?tof=sr4000");
  const TofImage turned = TofOf("synthetic:64x48?tof=sr4000&mirrored");
  EXPECT_EQ(turned.amplitude(9, 9), camera.amplitude(9, 176 - 1 - 9));
}

TEST(RangeErrors, TakesAwayReturnsThatWouldBeBehindTheCamera) {
  const TofImage tof = TofOf("synthetic:64x48?tof=grid&range=-100000");
  EXPECT_EQ(cv::countNonZero(tof.depth_m == tof.depth_m), 0);
}

TEST(RangeErrors, MakesMillimetresOfAMiddleburySceneThatHasNoDmin) {
  const SceneFolder folder(cv::Size(40, 555));
  const auto open = [&](const std::string& options) {
    CaptureConfig config = folder.Config();
    config.set_source(config.source() + options);
    return OpenDataset(config);
  };
  // Half size: f = 1870 px, d = 20 px and 250 / 2 px that are missing.
  const auto source = open("?range=10");
  const RectifiedPair pair = source->rig().pair;
  EXPECT_EQ(pair.cx_right - pair.cx, 125);
  const double length = RayLength(source->rig().tof, 3, 7);
  EXPECT_NEAR(source->Get(0).tof.depth_m(7, 3), 1870 * 0.16 / 145 + 0.01 / length, 1e-6);
  for (const std::string other : {"", "?bumps=3", "?mirrored"}) {
    const RectifiedPair same = open(other)->rig().pair;
    EXPECT_EQ(same.cx_right, same.cx) << other;
  }
  folder.WriteText("dmin.txt", "200");
  const RectifiedPair known = open("?range=10")->rig().pair;
  EXPECT_EQ(known.cx_right - known.cx, 100);
}

TEST(RangeErrors, MovesAndTurnsScans) {
  const KittiFolder folder("000007");
  EXPECT_NEAR(folder.Open("/000007?range=0.5")->Get(0).tof.depth_m(15, 20), 10.5, 1e-5);
  // f = 100 px: 1.75 px to the left; and down.
  folder.WriteScan("000007", {{10, 0, 0, 0}});
  const auto seen = [&](const std::string& options, int v, int u) {
    return folder.Open("/000007?" + options)->Get(0).tof.depth_m(v, u);
  };
  EXPECT_NEAR(seen("yaw=1", 15, 18), 10, 0.01);
  EXPECT_NEAR(seen("yaw=-1", 15, 22), 10, 0.01);
  EXPECT_NEAR(seen("pitch=1", 17, 20), 10, 0.01);
  EXPECT_NEAR(seen("pitch=-1&yaw=1&beams=64", 13, 18), 10, 0.01);
  EXPECT_NEAR(seen("mirrored", 15, 19), 10, 1e-6);
  EXPECT_NEAR(seen("unit=0.5", 15, 20), 5, 1e-6);
}

TEST(RangeErrors, RefusesWhatCannotBe) {
  const auto error = [](const std::string& source) {
    CaptureConfig config;
    config.set_source(source);
    return OpenError(config);
  };
  EXPECT_THAT(error("synthetic:64x48?range=x"),
              HasSubstr("range=x: not a number; allowed: &range"));
  EXPECT_THAT(error("synthetic:64x48?bumps=-1"), HasSubstr("capture.range_errors.bumps_px = -1"));
  EXPECT_THAT(error("synthetic:64x48?unit=0"), HasSubstr("capture.range_errors.unit = 0"));
  EXPECT_THAT(error("synthetic:64x48?mirrored=1"), HasSubstr("no such option mirrored=1"));
  EXPECT_THAT(error("synthetic:64x48?yaw=1"), HasSubstr("no such option yaw=1"));
  EXPECT_THAT(error("synthetic:64x48?tof=none&range=5"), HasSubstr("no such option range=5"));
  EXPECT_THAT(error("kitti:/nowhere?wiggle=5"), HasSubstr("no such option wiggle=5"));
}

}  // namespace
}  // namespace sprout::scenes
