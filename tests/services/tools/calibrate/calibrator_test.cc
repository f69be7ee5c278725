#include "services/tools/calibrate/calibrator.h"

#include <gmock/gmock.h>

#include <numbers>

#include "common/config/required.h"
#include "common/geometry/lens.h"
#include "common/rig/rectifier.h"
#include "services/tools/calibrate/coverage.h"
#include "tests/common/testing/thrown.h"
#include "tests/services/tools/calibrate/board_scene.h"

namespace sprout::calibrate {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

const cv::Size kImageSize(640, 480);

std::array<cv::Size, kCameraCount> SizesOf(const RawRig& rig) {
  return {rig.left.size(), rig.right.size(), rig.tof.size()};
}

double TurnDeg(const Pose& a, const Pose& b) {
  return a.rotation.angularDistance(b.rotation) * 180 / std::numbers::pi;
}

double ShiftMm(const Pose& a, const Pose& b) {
  return 1000 * (a.translation_m - b.translation_m).norm();
}

// The largest difference of rows on which the estimated rectification shows a thing that both true
// cameras see: 95 % are below, px.
double Epipolar95(const RawRig& truth, const RawRig& estimate) {
  const Rectifier rectifier(estimate);
  const cv::Rect2d image(0, 0, truth.left.width - 1, truth.left.height - 1);
  cv::RNG random(3);
  std::vector<double> errors;
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector2d left_pixel(random.uniform(0., image.width),
                                     random.uniform(0., image.height));
    const Eigen::Vector3d point =
        random.uniform(0.5, 4.) * DirectionOfPixel(truth.left, left_pixel).homogeneous();
    const Eigen::Vector3d in_right =
        truth.left_from_right.rotation.conjugate() * (point - truth.left_from_right.translation_m);
    const Eigen::Vector2d right_pixel = PixelOfDirection(truth.right, in_right.hnormalized());
    if (!image.contains({right_pixel.x(), right_pixel.y()})) continue;
    errors.push_back(std::abs(rectifier.LeftPixel({left_pixel.x(), left_pixel.y()}).y -
                              rectifier.RightPixel({right_pixel.x(), right_pixel.y()}).y));
  }
  std::ranges::sort(errors);
  return errors[errors.size() * 95 / 100];
}

double BiasErrorMm(const RawRig& truth, const RawRig& estimate, double range_m) {
  const double measured_m = (range_m - truth.range_offset_m) / truth.range_scale;
  return 1000 * std::abs(estimate.range_scale * measured_m + estimate.range_offset_m - range_m);
}

void ExpectWithinGoals(const RawRig& truth, const RawRig& estimate) {
  EXPECT_NEAR(estimate.left.fx / truth.left.fx, 1, 0.001);
  EXPECT_NEAR(estimate.left.fy / truth.left.fy, 1, 0.001);
  EXPECT_NEAR(estimate.right.fx / truth.right.fx, 1, 0.001);
  EXPECT_NEAR(estimate.right.fy / truth.right.fy, 1, 0.001);
  EXPECT_NEAR(estimate.tof.fx / truth.tof.fx, 1, 0.001);
  EXPECT_LT(TurnDeg(estimate.left_from_right, truth.left_from_right), 0.05);
  EXPECT_LT(ShiftMm(estimate.left_from_right, truth.left_from_right), 0.3);
  EXPECT_LT(TurnDeg(estimate.left_from_tof, truth.left_from_tof), 0.05);
  EXPECT_LT(ShiftMm(estimate.left_from_tof, truth.left_from_tof), 0.3);
  for (const double range_m : {0.7, 1., 1.3}) {
    EXPECT_LT(BiasErrorMm(truth, estimate, range_m), 1) << range_m;
  }
  EXPECT_LT(Epipolar95(truth, estimate), 0.1);
}

class Calibrator : public testing::Test {
 protected:
  std::vector<BoardView> Views(int count, double noise_px = 0.03) const {
    std::vector<BoardView> views;
    const std::vector<Pose> poses = BoardPoses(board_, count);
    for (uint32_t i = 0; i < poses.size(); ++i) {
      views.push_back(scene_.Project(poses[i], noise_px, i));
    }
    return views;
  }

  const Board board_{BoardSize{}};
  const RawRig rig_ = SceneRig(kImageSize);
  const BoardScene scene_{board_, rig_};
};

TEST_F(Calibrator, FindsTheRigFromTwentyFiveTriplets) {
  const RawRig rig = SceneRig({1024, 768});
  const BoardScene scene(board_, rig);
  ViewCollector collector(board_);
  const std::vector<Pose> poses = BoardPoses(board_, 25);
  for (uint32_t i = 0; i < poses.size(); ++i) {
    collector.Add(scene.Render(poses[i], i), std::nullopt);
  }
  ASSERT_GE(collector.views().size(), 24);

  const Calibration calibration = Required(Calibrate(board_, collector.sizes(), collector.views()));

  ExpectWithinGoals(rig, calibration.rig);
  const CalibrationQuality& quality = calibration.quality;
  EXPECT_THAT(quality.reasons, IsEmpty());
  EXPECT_LT(quality.cameras[kLeft].rms_px, 0.06);
  EXPECT_LT(quality.cameras[kTof].rms_px, 0.25);
  EXPECT_LT(quality.epipolar_median_px, 0.05);
  EXPECT_LT(quality.range_rms_m, 0.001);
}

TEST_F(Calibrator, KnowsHowFarItMayBeOff) {
  const Calibration calibration = Required(Calibrate(board_, SizesOf(rig_), Views(18)));

  const RawRig& found = calibration.rig;
  const auto& cameras = calibration.quality.cameras;
  const auto expect_within = [](double error, double deviation) {
    EXPECT_GT(deviation, 0);
    EXPECT_LT(std::abs(error), 4 * deviation);
  };
  expect_within(found.left.fx - rig_.left.fx, cameras[kLeft].deviation.lens[0]);
  expect_within(found.right.cx - rig_.right.cx, cameras[kRight].deviation.lens[2]);
  expect_within(found.tof.fx - rig_.tof.fx, cameras[kTof].deviation.lens[0]);
  for (Eigen::Index i = 0; i < 3; ++i) {
    const auto position = static_cast<size_t>(3 + i);
    expect_within(found.left_from_right.translation_m[i] - rig_.left_from_right.translation_m[i],
                  cameras[kRight].deviation.pose[position]);
    expect_within(found.left_from_tof.translation_m[i] - rig_.left_from_tof.translation_m[i],
                  cameras[kTof].deviation.pose[position]);
  }
}

TEST_F(Calibrator, GivesTheSameBytesAgain) {
  const Result<Calibration> a = Calibrate(board_, SizesOf(rig_), Views(8));
  const Result<Calibration> b = Calibrate(board_, SizesOf(rig_), Views(8));

  ASSERT_TRUE(a && b);
  EXPECT_EQ(a->rig.left.fx, b->rig.left.fx);
  EXPECT_EQ(a->rig.tof.distortion, b->rig.tof.distortion);
  EXPECT_EQ(a->rig.left_from_tof.rotation.coeffs(), b->rig.left_from_tof.rotation.coeffs());
  EXPECT_EQ(a->rig.range_offset_m, b->rig.range_offset_m);
}

TEST_F(Calibrator, LeavesOutCornersThatAreWrong) {
  std::vector<BoardView> views = Views(18);
  cv::RNG random(5);
  for (BoardView& view : views) {
    for (BoardCorners& corners : view.corners) {
      if (corners.pixels.empty()) continue;
      corners.pixels[corners.pixels.size() / 2] +=
          cv::Point2d(random.uniform(3., 9.), random.uniform(-9., -3.));
    }
  }
  const Calibration calibration = Required(Calibrate(board_, SizesOf(rig_), views));

  EXPECT_NEAR(calibration.rig.left.fx / rig_.left.fx, 1, 0.001);
  EXPECT_LT(TurnDeg(calibration.rig.left_from_right, rig_.left_from_right), 0.05);
  EXPECT_GE(calibration.quality.cameras[kLeft].outliers, 15);
}

TEST_F(Calibrator, DoesWithoutAToFCamera) {
  std::vector<BoardView> views = Views(16);
  for (BoardView& view : views) {
    view.corners[kTof] = {};
    view.tof = {};
  }
  const Calibration calibration =
      Required(Calibrate(board_, {kImageSize, kImageSize, cv::Size()}, views));

  EXPECT_EQ(calibration.rig.tof.width, 0);
  EXPECT_LT(TurnDeg(calibration.rig.left_from_right, rig_.left_from_right), 0.05);
  EXPECT_THAT(calibration.quality.reasons, IsEmpty());
}

TEST_F(Calibrator, UsesViewsThatOneCameraHas) {
  std::vector<BoardView> views = Views(26);
  for (size_t i = 0; i < 5; ++i) views[i].corners[kLeft] = {};
  for (size_t i = 5; i < 10; ++i) views[i].corners[kRight] = {};

  const Calibration calibration = Required(Calibrate(board_, SizesOf(rig_), views));

  EXPECT_EQ(calibration.quality.cameras[kLeft].views, 21);
  EXPECT_LT(ShiftMm(calibration.rig.left_from_right, rig_.left_from_right), 0.3);
}

TEST_F(Calibrator, SaysWhereTheBoardWasNotShown) {
  std::vector<BoardView> views = Views(18);
  for (BoardView& view : views) {
    BoardCorners kept;
    const BoardCorners& all = view.corners[kRight];
    for (size_t i = 0; i < all.ids.size(); ++i) {
      if (all.pixels[i].x < kImageSize.width / 3 + 2 && all.pixels[i].y < kImageSize.height / 3 + 2)
        continue;
      kept.ids.push_back(all.ids[i]);
      kept.pixels.push_back(all.pixels[i]);
    }
    view.corners[kRight] = kept;
  }
  const Calibration calibration = Required(Calibrate(board_, SizesOf(rig_), views));

  EXPECT_THAT(calibration.quality.reasons,
              testing::ElementsAre(
                  "the right image's upper left ninth has no corner: show the board there"));
}

TEST_F(Calibrator, SaysWhyFewOrBadViewsAreNotGoodEnough) {
  const Calibration few = Required(Calibrate(board_, SizesOf(rig_), Views(8)));
  EXPECT_THAT(few.quality.reasons,
              Contains(HasSubstr("the left camera sees the board in 8 views only")));

  const Calibration blurred = Required(Calibrate(board_, SizesOf(rig_), Views(16, 0.8)));
  EXPECT_THAT(blurred.quality.reasons, Contains(HasSubstr("corners of the left image are 1.1")));
}

TEST_F(Calibrator, RefusesTooFewViews) {
  EXPECT_THAT(WhyNot(Calibrate(board_, SizesOf(rig_), {})),
              HasSubstr("the left camera sees 6 corners of the board in 0 views"));

  std::vector<BoardView> views = Views(16);
  for (size_t i = 0; i < 13; ++i) views[i].corners[kTof] = {};
  EXPECT_THAT(WhyNot(Calibrate(board_, SizesOf(rig_), views)),
              HasSubstr("the ToF camera sees 6 corners of the board in 3 views"));
}

TEST_F(Calibrator, RefusesViewsThatLeaveTheLensOpen) {
  // One pose, straight ahead, again and again.
  const Pose pose{.translation_m = {-0.27, -0.18, 1}};
  std::vector<BoardView> views;
  for (uint32_t i = 0; i < 6; ++i) views.push_back(scene_.Project(pose, 0.03, i));

  const Result<Calibration> calibration = Calibrate(board_, SizesOf(rig_), views);

  if (calibration) {
    EXPECT_THAT(calibration->quality.reasons, Contains(HasSubstr("focal length is known to")));
  } else {
    EXPECT_THAT(calibration.error().text, HasSubstr("do not determine"));
  }
}

TEST_F(Calibrator, NoticesSwappedCameras) {
  std::vector<BoardView> views = Views(16);
  for (BoardView& view : views) std::swap(view.corners[kLeft], view.corners[kRight]);

  EXPECT_THAT(WhyNot(Calibrate(board_, SizesOf(rig_), views)),
              HasSubstr("are the left and the right camera swapped?"));
}

TEST_F(Calibrator, NoticesOneCameraTwice) {
  std::vector<BoardView> views = Views(16);
  for (BoardView& view : views) view.corners[kRight] = view.corners[kLeft];

  EXPECT_THAT(WhyNot(Calibrate(board_, SizesOf(rig_), views)),
              HasSubstr("are left and right images of one camera?"));
}

}  // namespace
}  // namespace sprout::calibrate
