#include "services/selfcalibrate/rig_watch.h"

#include <fmt/core.h>
#include <gmock/gmock.h>

#include <cmath>
#include <ctime>
#include <functional>
#include <iostream>
#include <numbers>

#include "common/geometry/lens.h"
#include "common/rig/rectifier.h"
#include "common/scenes/dataset.h"
#include "services/tools/calibrate/scene/rig_change.h"
#include "tests/services/tools/calibrate/knocked_scene.h"

namespace sprout::selfcalibrate {
namespace {

using calibrate::Changed;
using calibrate::RenderScene;
using calibrate::RigImages;
using calibrate::RigNumbers;
using testing::HasSubstr;

using Verdict = RigChange::Verdict;

constexpr double kDegree = std::numbers::pi / 180;
constexpr int kFrames = 2;

SelfCalibrateConfig Config() {
  SelfCalibrateConfig config;
  config.set_frames(kFrames);
  return config;
}

// Frames of a real rig, rectified by the calibration `calibrated`.
class WatchedRig {
 public:
  explicit WatchedRig(const RawRig& calibrated)
      : made_(RectificationOf(calibrated)), rectifier_(calibrated), watch_(Config()) {}

  Result<std::optional<RigChange>> Add(const RigImages& raw) {
    const Result<RigImages> images = RectifyImages(rectifier_, raw);
    EXPECT_TRUE(images) << images.error().text;
    Frame frame;
    frame.id = {.utime = 1000 + seq_, .seq = seq_, .rig_id = RigId(rectifier_.rig())};
    ++seq_;
    frame.left = images->left;
    frame.right = images->right;
    frame.tof = images->tof;
    frame.rig = rectifier_.rig();
    return watch_.Add(frame);
  }

  // The result of kFrames frames of a scene.
  RigChange See(const RawRig& real, bool with_tof = true, uint32_t scene = 3) {
    for (int i = 1; i < kFrames; ++i) {
      const auto nothing = Add(RenderScene(real, scene, 20 * seq_, with_tof));
      EXPECT_TRUE(nothing && !*nothing);
    }
    return SeeOne(RenderScene(real, scene, 20 * seq_, with_tof));
  }

  RigChange SeeOne(const RigImages& raw) {
    const Result<std::optional<RigChange>> seen = Add(raw);
    EXPECT_TRUE(seen && *seen);
    return seen && *seen ? **seen : RigChange();
  }

  const RangeCorrection& curve() const { return watch_.curve(); }

  // A turn about the axes of the unrectified left camera, in those of the rectified one.
  Eigen::Vector3d Rectified(double pitch, double yaw, double roll) const {
    return BackOf(made_.left_turn).transpose() * Eigen::Vector3d(pitch, yaw, roll);
  }

  const Rig& rig() const { return rectifier_.rig(); }

 private:
  Rectification made_;
  Rectifier rectifier_;
  RigWatch watch_;
  int64_t seq_ = 0;
};

void ExpectWithinThreeSigmas(const SeenTurn& seen, const Eigen::Vector3d& true_turn, double most) {
  for (Eigen::Index i = 0; i < 3; ++i) {
    EXPECT_GT(seen.sigma[i], 0) << i;
    EXPECT_LT(std::abs(seen.turn[i] - true_turn[i]), 3 * seen.sigma[i]) << i;
    EXPECT_LT(std::abs(seen.turn[i] - true_turn[i]), most) << i;
  }
}

TEST(RigWatch, SeesAKnockInTheMiddleOfARun) {
  const RawRig rig = calibrate::TrueRig({640, 480});
  WatchedRig watched(rig);
  const RigChange before = watched.See(rig);
  EXPECT_EQ(before.verdict, Verdict::kRight) << before.reason;
  EXPECT_EQ(before.frames, kFrames);
  EXPECT_EQ(before.newest_frame.seq, kFrames - 1);
  EXPECT_EQ(before.newest_frame.rig_id, RigId(watched.rig()));
  EXPECT_NEAR(before.rows_px, 0, 3 * before.rows_sigma_px);
  EXPECT_GT(before.tof_matches, 60);

  RigNumbers knock{};
  knock[calibrate::kPitch] = 0.15 * kDegree;
  knock[calibrate::kYaw] = -0.2 * kDegree;
  knock[calibrate::kRoll] = 0.1 * kDegree;
  const RigChange after = watched.See(Changed(rig, knock));

  EXPECT_EQ(after.verdict, Verdict::kWrong) << after.reason;
  ExpectWithinThreeSigmas(after.right,
                          watched.Rectified(0.15 * kDegree, -0.2 * kDegree, 0.1 * kDegree),
                          0.02 * kDegree);
  // A camera that looks up sees things farther down.
  const double rows_px = 0.15 * kDegree * watched.rig().pair.focal_px;
  EXPECT_NEAR(after.rows_px, rows_px, 0.1 * std::abs(rows_px));
  EXPECT_GT(after.rows_spread_px, 5 * before.rows_spread_px);  // the roll
}

TEST(RigWatch, SeesATurnedToFCameraAndItsRanges) {
  const RawRig rig = calibrate::TrueRig({640, 480});
  WatchedRig watched(rig);
  RigNumbers knock{};
  knock[calibrate::kTofPitch] = -0.5 * kDegree;
  knock[calibrate::kTofYaw] = 0.7 * kDegree;
  knock[calibrate::kRangeOffset] = 0.03;
  RigNumbers only_turned = knock;
  only_turned[calibrate::kRangeOffset] = 0;
  // Ranges that are 30 mm too short: the camera that is calibrated must add them.
  const RawRig real = Changed(rig, only_turned);
  const auto shortened = [&](RigImages images) {
    const cv::Mat1d per_depth = RangePerDepth(rig.tof);
    for (int v = 0; v < images.tof.depth_m.rows; ++v) {
      for (int u = 0; u < images.tof.depth_m.cols; ++u) {
        images.tof.depth_m(v, u) -= static_cast<float>(0.03 / per_depth(v, u));
      }
    }
    return images;
  };
  for (int i = 1; i < kFrames; ++i) {
    ASSERT_TRUE(watched.Add(shortened(RenderScene(real, 3, 20 * i, true))));
  }
  const RigChange seen = watched.SeeOne(shortened(RenderScene(real, 3, 0, true)));

  EXPECT_EQ(seen.verdict, Verdict::kWrong) << seen.reason;
  ExpectWithinThreeSigmas(seen.tof, watched.Rectified(-0.5 * kDegree, 0.7 * kDegree, 0),
                          0.1 * kDegree);
  EXPECT_NEAR(seen.range_offset_m, 0.03, std::min(3 * seen.range_sigma_m, 0.005));
  for (const double turn : seen.right.turn) EXPECT_LT(std::abs(turn), 0.02 * kDegree);
}

// The curve that the watch finds for ranges that are off by `error_m` along the ray.
RangeCorrection CurveFor(const std::function<double(double)>& error_m) {
  const RawRig rig = calibrate::TrueRig({640, 480});
  WatchedRig watched(rig);
  const cv::Mat1d per_depth = RangePerDepth(rig.tof);
  for (int i = 1; i <= kFrames; ++i) {
    RigImages images = RenderScene(rig, 3, 20 * i, true);
    for (int j = 0; j < static_cast<int>(per_depth.total()); ++j) {
      images.tof.depth_m(j) +=
          static_cast<float>(error_m(images.tof.depth_m(j) * per_depth(j)) / per_depth(j));
    }
    const auto seen = watched.Add(images);
    EXPECT_TRUE(seen);
    EXPECT_TRUE(i < kFrames || (*seen)->verdict != Verdict::kUnseen) << (*seen)->reason;
  }
  return watched.curve();
}

TEST(RigWatch, LearnsWhatTheSimulatedSensorIsOffBy) {
  EXPECT_TRUE(CurveFor([](double) { return 0; }).empty()) << "a right one is left alone";
  const std::function<double(double)> errors[] = {
      [](double) { return 0.01; },
      [](double range_m) { return 0.01 * std::sin(2 * std::numbers::pi * range_m / 1.25); }};
  for (const auto& error_m : errors) {
    const RangeCorrection curve = CurveFor(error_m);
    ASSERT_FALSE(curve.empty());
    ptrdiff_t sure = 0;
    for (const CorrectionKnot& knot : curve) {
      const double left_m = knot.offset_m + error_m(knot.range_m);
      EXPECT_LT(std::abs(left_m), 3 * knot.sigma_m) << knot.range_m;
      if (knot.sigma_m > 0.0075) continue;
      ++sure;
      EXPECT_LT(std::abs(left_m), 0.005) << knot.range_m;
    }
    EXPECT_GE(2 * sure, std::ssize(curve));
  }
}

TEST(RigWatch, SeesRowsButNoYawWithoutToFCamera) {
  const RawRig rig = calibrate::TrueRig({640, 480});
  WatchedRig watched(rig);
  RigNumbers knock{};
  knock[calibrate::kYaw] = 0.3 * kDegree;
  const RigChange yaw = watched.See(Changed(rig, knock), /*with_tof=*/false);
  EXPECT_EQ(yaw.verdict, Verdict::kRight) << yaw.reason;
  EXPECT_EQ(yaw.right.turn[1], 0);
  EXPECT_EQ(yaw.right.sigma[1], -1);
  EXPECT_EQ(yaw.tof, SeenTurn());
  EXPECT_EQ(yaw.range_sigma_m, -1);

  knock[calibrate::kPitch] = 0.2 * kDegree;
  const RigChange both = watched.See(Changed(rig, knock), /*with_tof=*/false);
  EXPECT_EQ(both.verdict, Verdict::kWrong) << both.reason;
  EXPECT_NEAR(both.right.turn[0], 0.2 * kDegree, 0.02 * kDegree);
  EXPECT_EQ(both.right.turn[1], 0);
}

// One plane tells no turn, but rows that are apart are seen.
TEST(RigWatch, SaysHowFarRowsAreApartWhereNoCalibrationCanBeTold) {
  const RawRig rig = calibrate::TrueRig({640, 480});
  std::vector<scenes::Solid> wall = scenes::SyntheticScene(0, 1).At(0);
  wall.resize(1);
  for (const double pitch_deg : {0.3, 1.0}) {
    RigNumbers turn{};
    turn[calibrate::kPitch] = pitch_deg * kDegree;
    const RawRig real = Changed(rig, turn);
    WatchedRig watched(rig);
    for (uint32_t i = 1; i < kFrames; ++i) {
      ASSERT_TRUE(watched.Add(calibrate::RenderSolids(real, wall, i, true)));
    }
    const RigChange seen = watched.SeeOne(calibrate::RenderSolids(real, wall, 0, true));
    EXPECT_EQ(seen.verdict, Verdict::kUnseen);
    EXPECT_THAT(seen.reason, HasSubstr("too flat"));
    const double rows_px = std::tan(pitch_deg * kDegree) * watched.rig().pair.focal_px;
    double said_px = 0;
    ASSERT_EQ(std::sscanf(seen.reason.c_str(), "rows of the right image lie %lf", &said_px), 1)
        << seen.reason;
    EXPECT_NEAR(said_px, rows_px, 0.05 * rows_px) << seen.reason;
  }
}

TEST(RigWatch, SaysThatBlackImagesShowNothing) {
  const RawRig rig = calibrate::TrueRig({320, 240});
  WatchedRig watched(rig);
  const RigImages black{
      .left = cv::Mat1b::zeros(240, 320), .right = cv::Mat1b::zeros(240, 320), .tof = {}};
  for (int i = 1; i < kFrames; ++i) ASSERT_TRUE(watched.Add(black));
  const RigChange seen = watched.SeeOne(black);

  EXPECT_EQ(seen.verdict, Verdict::kUnseen);
  EXPECT_THAT(seen.reason, HasSubstr("0 matches of 0 features in 2 frames"));
  EXPECT_EQ(seen.right, SeenTurn());
  EXPECT_EQ(seen.tof, SeenTurn());
  EXPECT_EQ(seen.rows_sigma_px, -1);
}

TEST(RigWatch, SaysThatFramesBeforeAndAfterAKnockContradictOneAnother) {
  const RawRig rig = calibrate::TrueRig({640, 480});
  RigNumbers knock{};
  knock[calibrate::kPitch] = 0.3 * kDegree;
  WatchedRig watched(rig);
  for (int i = 1; i < kFrames; ++i) ASSERT_TRUE(watched.Add(RenderScene(rig, 3, 20 * i, true)));
  const RigChange mixed = watched.SeeOne(RenderScene(Changed(rig, knock), 3, 40, true));
  EXPECT_EQ(mixed.verdict, Verdict::kUnseen);
  EXPECT_EQ(mixed.right, SeenTurn());

  const RigChange after = watched.See(Changed(rig, knock));
  EXPECT_EQ(after.verdict, Verdict::kWrong) << after.reason;
}

TEST(RigWatch, StartsAgainWithAnotherCalibration) {
  const RawRig rig = calibrate::TrueRig({320, 240});
  SelfCalibrateConfig config;
  config.set_frames(2);
  RigWatch watch(config);
  Frame frame;
  frame.left = frame.right = cv::Mat1b(240, 320, uint8_t{0});
  frame.tof = TofImage();
  frame.rig = Rectifier(rig).rig();
  const auto has_result = [&](const char* rig_id) {
    frame.id.rig_id = rig_id;
    const auto seen = watch.Add(frame);
    EXPECT_TRUE(seen);
    return seen && seen->has_value();
  };
  EXPECT_FALSE(has_result("a"));
  EXPECT_FALSE(has_result("b"));
  EXPECT_TRUE(has_result("b"));
  EXPECT_FALSE(has_result("b"));
}

TEST(RigWatch, RefusesImagesOfAnotherSize) {
  RigWatch watch(Config());
  Frame frame;
  frame.left = frame.right = cv::Mat1b(24, 32, uint8_t{0});
  frame.tof = TofImage();
  frame.rig = Rectifier(calibrate::TrueRig({320, 240})).rig();
  const auto seen = watch.Add(frame);
  ASSERT_FALSE(seen);
  EXPECT_THAT(seen.error().text, HasSubstr("allowed is the calibrated size"));
}

// By hand, with --gtest_also_run_disabled_tests: the times of NOTES.md, one thread.
TEST(RigWatch, DISABLED_TimeAt2Mp) {
  const auto source = scenes::OpenDataset("synthetic:1600x1250?tof=sr4000");
  SelfCalibrateConfig config;  // defaults
  RigWatch watch(config);
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1);
  // First a right one, then one with two rows of error.
  for (int64_t seq = 0; seq < 2 * config.frames(); ++seq) {
    const scenes::DatasetFrame captured = source->Get(10 * seq);
    Frame frame;
    frame.id.rig_id = RigId(source->rig());
    frame.left = captured.left;
    frame.right = captured.right;
    if (seq >= config.frames()) {
      frame.right = captured.right.clone();
      captured.right.rowRange(0, 1248).copyTo(frame.right.rowRange(2, 1250));
    }
    frame.tof = captured.tof;
    frame.rig = source->rig();
    const std::clock_t start = std::clock();
    const auto seen = watch.Add(frame);
    std::cout << fmt::format("frame {}: {:.0f} ms of CPU\n", seq,
                             1000.0 * static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
    ASSERT_TRUE(seen);
    if (*seen) std::cout << ChangeText(**seen, source->rig().pair) << "\n";
  }
  cv::setNumThreads(threads);
}

TEST(RigWatch, RefusesAConfigurationOutOfRange) {
  SelfCalibrateConfig config;
  config.set_frames(25);
  EXPECT_THROW(RigWatch{config}, ConfigError);
}

}  // namespace
}  // namespace sprout::selfcalibrate
