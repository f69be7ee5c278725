#include "common/rig/rectifier.h"

#include <gmock/gmock.h>
#include <hwy/targets.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "common/geometry/lens.h"
#include "common/geometry/projection.h"
#include "tests/common/rig/tilted_rig.h"

namespace sprout {
namespace {

const std::vector<Eigen::Vector3d> kPointsInLeft = {
    {0, 0, 1}, {-0.4, -0.3, 1.1}, {0.5, 0.3, 1.5}, {-1, 0.9, 3}, {1.5, -1, 4}, {0.2, 2, 8}};

// Pixel at which an unrectified camera sees a point of the left one's frame.
cv::Point2d RawPixel(const Lens& lens, const Pose& left_from_camera,
                     const Eigen::Vector3d& in_left) {
  const Eigen::Vector3d in_camera = left_from_camera.rotation.toRotationMatrix().transpose() *
                                    (in_left - left_from_camera.translation_m);
  const Eigen::Vector2d pixel = PixelOfDirection(lens, in_camera.hnormalized());
  return {pixel.x(), pixel.y()};
}

TEST(Rectifier, PutsBothImagesOfAPointOnOneRow) {
  const RawRig raw = TiltedRig();
  const Rectifier rectifier(raw);
  for (const Eigen::Vector3d& point : kPointsInLeft) {
    const cv::Point2d left = rectifier.LeftPixel(RawPixel(raw.left, {}, point));
    const cv::Point2d right = rectifier.RightPixel(RawPixel(raw.right, raw.left_from_right, point));
    EXPECT_NEAR(left.y, right.y, 1e-6);
    EXPECT_GT(left.x - right.x, 0);
  }
}

TEST(Rectifier, GivesTheRigThatSeesThePointsWhereTheImagesHaveThem) {
  const RawRig raw = TiltedRig();
  const Rectifier rectifier(raw);
  const Rig& rig = rectifier.rig();
  EXPECT_TRUE(CheckRig(rig));
  EXPECT_NEAR(rig.pair.baseline_m, raw.left_from_right.translation_m.norm(), 1e-12);
  for (const Eigen::Vector3d& point : kPointsInLeft) {
    const cv::Point2d left = rectifier.LeftPixel(RawPixel(raw.left, {}, point));
    const cv::Point2d right = rectifier.RightPixel(RawPixel(raw.right, raw.left_from_right, point));
    // The turn of the left camera keeps distances.
    const Eigen::Vector3d again = PointFromSeed(
        rig.pair, {.u = float(left.x), .v = float(left.y), .u_right = float(right.x)});
    EXPECT_NEAR(again.norm(), point.norm(), 1e-4 * point.norm());
  }
}

TEST(Rectifier, TurnsThePoseOfTheToFCameraWithTheLeftOne) {
  const RawRig raw = TiltedRig();
  const Rectifier rectifier(raw);
  const TofCamera& tof = rectifier.rig().tof;
  EXPECT_EQ(tof.lens().size(), raw.tof.size());
  for (const Eigen::Vector3d& in_tof : kPointsInLeft) {
    const Eigen::Vector3d in_left =
        raw.left_from_tof.rotation.toRotationMatrix() * in_tof + raw.left_from_tof.translation_m;
    const Eigen::Vector3d in_rectified =
        tof.left_from_tof_rotation.toRotationMatrix() * in_tof + tof.left_from_tof_translation_m;
    const Seed seed = ProjectToPair(rectifier.rig().pair, in_rectified);
    const cv::Point2d left = rectifier.LeftPixel(RawPixel(raw.left, {}, in_left));
    EXPECT_NEAR(seed.u, left.x, 1e-3);
    EXPECT_NEAR(seed.v, left.y, 1e-3);
  }
}

// A picture whose grey value tells the column or the row, smooth enough for bilinear weights.
cv::Mat1b Ramp(cv::Size size, bool along_row) {
  cv::Mat1b ramp(size);
  for (int v = 0; v < ramp.rows; ++v) {
    for (int u = 0; u < ramp.cols; ++u) {
      ramp(v, u) = static_cast<uchar>(along_row ? u * 250 / size.width : v * 250 / size.height);
    }
  }
  return ramp;
}

TEST(Rectifier, FillsEveryPixelFromWhereTheCameraSawIt) {
  const RawRig raw = TiltedRig();
  const Rectifier rectifier(raw);
  for (const bool along_row : {false, true}) {
    const cv::Mat1b left = Ramp(raw.left.size(), along_row);
    const cv::Mat1b rectified = rectifier.RectifyLeft(left);
    ASSERT_EQ(rectified.size(), rectifier.rig().pair.size());
    for (const auto& [u, v] : {std::pair{20, 30}, {320, 240}, {600, 20}, {100, 450}}) {
      const cv::Point2d lands = rectifier.LeftPixel({double(u), double(v)});
      if (lands.x < 0 || lands.y < 0 || lands.x > 638 || lands.y > 478) continue;
      EXPECT_NEAR(rectified(cvRound(lands.y), cvRound(lands.x)), left(v, u), 1);
    }
  }
}

TEST(Rectifier, LeavesNoBlackBorder) {
  const RawRig raw = TiltedRig();
  const Rectifier rectifier(raw);
  const cv::Mat1b white(raw.left.size(), uchar{255});
  EXPECT_EQ(cv::countNonZero(rectifier.RectifyLeft(white) < 255), 0);
  EXPECT_EQ(cv::countNonZero(rectifier.RectifyRight(white) < 255), 0);
  const cv::Mat coloured(raw.left.size(), CV_8UC3, cv::Scalar(1, 2, 3));
  EXPECT_EQ(rectifier.RectifyLeft(coloured).type(), CV_8UC3);
}

TEST(Rectifier, TakesTheBiasOutOfTheRangeAlongTheRay) {
  const RawRig raw = TiltedRig();
  const Rectifier rectifier(raw);
  TofImage tof{.depth_m = cv::Mat1f(raw.tof.size(), 2.f), .amplitude = {}};
  tof.depth_m(0, 0) = std::numeric_limits<float>::quiet_NaN();
  const cv::Mat1f measured = tof.depth_m;
  rectifier.CorrectRanges(tof);
  EXPECT_TRUE(std::isnan(tof.depth_m(0, 0)));
  EXPECT_EQ(measured(1, 1), 2) << "the caller's image";
  for (const auto& [u, v] : {std::pair{88, 71}, {3, 140}, {175, 0}}) {
    const double length = DirectionOfPixel(raw.tof, {double(u), double(v)}).homogeneous().norm();
    EXPECT_NEAR(tof.depth_m(v, u) * length, 1.01 * 2 * length - 0.02, 1e-6);
  }
  TofImage none;
  rectifier.CorrectRanges(none);
  EXPECT_TRUE(none.depth_m.empty());
}

TEST(Rectifier, AddsTheCorrectionOfTheRangesAfterScaleAndOffset) {
  RawRig raw = TiltedRig();
  raw.range_correction = {{1, 0.01, 0}, {2, 0.03, 0}, {3, -0.01, 0}};
  const Rectifier rectifier(raw);
  for (const auto& [depth_m, u, v] :
       {std::tuple{0.5F, 88, 71}, {1.3F, 3, 140}, {2.2F, 175, 0}, {9.F, 40, 40}}) {
    TofImage tof{.depth_m = cv::Mat1f(raw.tof.size(), depth_m), .amplitude = {}};
    rectifier.CorrectRanges(tof);
    const double length = DirectionOfPixel(raw.tof, {double(u), double(v)}).homogeneous().norm();
    const double range_m = 1.01 * depth_m * length - 0.02;
    const double offset_m = range_m < 1   ? 0.01
                            : range_m < 2 ? 0.01 + 0.02 * (range_m - 1)
                            : range_m < 3 ? 0.03 - 0.04 * (range_m - 2)
                                          : -0.01;
    EXPECT_NEAR(tof.depth_m(v, u) * length, range_m + offset_m, 2e-6) << depth_m;
  }
}

TEST(Rectifier, AddsWhatDependsOnTheAmplitude) {
  RawRig raw = TiltedRig();
  raw.amplitude_correction = {.offset_m = -0.02, .sigma_m = 0.001, .middle = 300};
  const Rectifier rectifier(raw);
  const auto added_m = [&](float amplitude) {
    TofImage tof{.depth_m = cv::Mat1f(raw.tof.size(), 2.F),
                 .amplitude = cv::Mat1f(raw.tof.size(), amplitude)};
    rectifier.CorrectRanges(tof);
    const double length = DirectionOfPixel(raw.tof, {88, 71}).homogeneous().norm();
    return tof.depth_m(71, 88) * length - (1.01 * 2 * length - 0.02);
  };
  EXPECT_NEAR(added_m(300), 0, 2e-6);
  EXPECT_NEAR(added_m(1e-3F), 0.01, 2e-6);
  EXPECT_NEAR(added_m(900), -0.005, 2e-6);
  EXPECT_NEAR(added_m(1e9F), -0.01, 2e-6);
  EXPECT_NEAR(added_m(0), 0, 2e-6) << "not known";
  TofImage without{.depth_m = cv::Mat1f(raw.tof.size(), 2.F), .amplitude = {}};
  rectifier.CorrectRanges(without);
  EXPECT_NEAR(without.depth_m(71, 88), 2, 0.03);
}

TEST(Rectifier, ServesARigWithoutAToFCamera) {
  RawRig raw = TiltedRig();
  raw.tof = {};
  EXPECT_TRUE(CheckRawRig(raw));
  EXPECT_EQ(Rectifier(raw).rig().tof.width, 0);
}

RawRig WithRightTurned(double degrees, const Eigen::Vector3d& axis) {
  RawRig rig = TiltedRig();
  rig.left_from_right.rotation =
      Eigen::Quaterniond(Eigen::AngleAxisd(degrees * std::numbers::pi / 180, axis));
  return rig;
}

TEST(Rectifier, TellsWhatItsImagesShow) {
  const RectifiedViews usual = Rectifier(TiltedRig()).views();
  EXPECT_GT(usual.rows, 0.9);
  EXPECT_GT(usual.kept, 0.7);
  EXPECT_EQ(usual.filled, 1);
  EXPECT_EQ(ViewsWarning(usual), "");

  // A third of the field of view of 63 degrees, and of that of 49 degrees.
  const RectifiedViews squinting = Rectifier(WithRightTurned(21, {0, 1, 0})).views();
  EXPECT_GT(squinting.rows, 0.95);
  EXPECT_NEAR(squinting.kept, 0.32, 0.03);
  EXPECT_THAT(ViewsWarning(squinting), testing::HasSubstr("show 32 % of what one of the cameras"));
  const RectifiedViews nodding = Rectifier(WithRightTurned(15, {1, 0, 0})).views();
  EXPECT_NEAR(nodding.rows, 0.65, 0.03);
  EXPECT_NEAR(nodding.kept, 0.38, 0.03);
  EXPECT_NE(ViewsWarning(nodding), "");
}

// All over an image and beyond it, as a lens would have it.
cv::Mat2f Places(cv::Size size, cv::Size source) {
  cv::Mat2f places(size);
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) {
      const double x = 1.2 * (u + 0.5) / size.width - 0.1;
      const double y = 1.2 * (v + 0.5) / size.height - 0.1;
      places(v, u) = {static_cast<float>((x + 0.05 * y * y) * source.width - 0.5),
                      static_cast<float>((y - 0.05 * x) * source.height - 0.5)};
    }
  }
  return places;
}

cv::Mat Noise(cv::Size size, int type) {
  cv::Mat image(size, type);
  cv::RNG(5).fill(image, cv::RNG::UNIFORM, 0, 256);
  return image;
}

void ExpectAsOpenCv(cv::Size size, cv::Size source) {
  const cv::Mat2f places = Places(size, source);
  const BilinearRemap remap(places, source);
  cv::Mat whole, fraction;
  cv::convertMaps(places, cv::noArray(), whole, fraction, CV_16SC2);
  for (const int type : {CV_8UC1, CV_8UC3}) {
    const cv::Mat image = Noise(source, type);
    cv::Mat expected;
    cv::remap(image, expected, whole, fraction, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
    const cv::Mat found = remap.Apply(image);
    ASSERT_EQ(found.type(), type);
    EXPECT_EQ(cv::norm(found, expected, cv::NORM_INF), 0) << size << " of " << source;
  }
}

TEST(BilinearRemap, GivesTheBytesOfOpenCv) {
  ExpectAsOpenCv({640, 480}, {640, 480});
  ExpectAsOpenCv({65, 7}, {31, 90});
  ExpectAsOpenCv({3, 200}, {2, 2});
}

TEST(BilinearRemap, GivesTheSameBytesWithEveryInstructionSet) {
  const int64_t all = hwy::SupportedTargets();
  for (int64_t rest = all; rest != 0; rest &= rest - 1) {
    hwy::SetSupportedTargetsForTest(rest & -rest);
    hwy::GetChosenTarget().DeInit();  // chosen anew at the next call
    ExpectAsOpenCv({130, 50}, {120, 60});
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().DeInit();
}

TEST(BilinearRemap, TakesAPartOfALargerImage) {
  const BilinearRemap remap(Places({40, 30}, {50, 20}), {50, 20});
  const cv::Mat part = Noise({80, 40}, CV_8UC3)(cv::Rect(7, 9, 50, 20));
  EXPECT_EQ(cv::norm(remap.Apply(part), remap.Apply(part.clone()), cv::NORM_INF), 0);
}

}  // namespace

}  // namespace sprout
