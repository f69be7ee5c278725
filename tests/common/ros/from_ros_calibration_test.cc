#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <string>
#include <vector>

#include "common/geometry/lens.h"
#include "common/ros/from_ros.h"
#include "tests/common/ros/ros_examples.h"

namespace sprout {
namespace {

using examples::ErrorOf;
using examples::Place;
using testing::HasSubstr;

TEST(FromRos, ThePairComesBack) {
  const RectifiedPair pair = examples::Rig().pair;
  const auto left = FromRosInfo(*ToRosLeftInfo(Place(), pair));
  const auto right = FromRosInfo(*ToRosRightInfo(Place(), pair));
  ASSERT_TRUE(left && right);
  EXPECT_EQ(right->tx, -500 * 0.125);
  const Result<RectifiedPair> back = PairOf(*left, *right);
  ASSERT_TRUE(back) << ErrorOf(back);
  EXPECT_EQ(RigId({.pair = *back, .tof = {}}), RigId({.pair = pair, .tof = {}}));
  EXPECT_THAT(ErrorOf(PairOf(*right, *left)),
              HasSubstr("right p[3] = 0: allowed is −f·b, below the left camera's, -62.5; are they "
                        "swapped?"));
}

// KITTI's third and fourth camera, whose Tx is relative to the first one.
TEST(FromRos, TheBaselineIsTheDifferenceOfBothTx) {
  const RectifiedPair pair = examples::Rig().pair;
  auto left_info = ToRosLeftInfo(Place(), pair);
  auto right_info = ToRosRightInfo(Place(), pair);
  for (const double shift : {44.86, -100.0}) {
    left_info->p[3] = shift;
    right_info->p[3] = shift - 500 * 0.125;
    const Result<RectifiedPair> back = PairOf(*FromRosInfo(*left_info), *FromRosInfo(*right_info));
    ASSERT_TRUE(back) << ErrorOf(back);
    EXPECT_NEAR(back->baseline_m, 0.125, 1e-12);
  }
}

// The same camera with another lens in K and D.
RosMessage<RosCameraInfo> WithLens(const RosCameraInfo& of, const std::string& model,
                                   const std::vector<double>& d) {
  RosMessage<RosCameraInfo> info;
  info->width = of.width;
  info->height = of.height;
  std::ranges::copy(of.k, info->k);
  std::ranges::copy(of.r, info->r);
  std::ranges::copy(of.p, info->p);
  info->k[0] *= 1.5;
  SetRosText(info->distortion_model, model);
  std::ranges::copy(d, ResizeRos(info->d, d.size()).begin());
  return info;
}

// Rectified images whose drivers keep the lens of the raw ones in their messages.
TEST(FromRos, ThePairIsPWhateverTheLens) {
  const RectifiedPair pair = examples::Rig().pair;
  for (const char* model : {"rational_polynomial", "equidistant", "thin_prism_fisheye"}) {
    const std::vector<double> d(model[0] == 'e' ? 4 : 8, 0.25);
    const auto left = FromRosInfo(*WithLens(*ToRosLeftInfo(Place(), pair), model, d));
    ASSERT_TRUE(left) << ErrorOf(left);
    const auto right = FromRosInfo(*WithLens(*ToRosRightInfo(Place(), pair), model, d));
    const Result<RectifiedPair> back = PairOf(*left, *right);
    ASSERT_TRUE(back) << ErrorOf(back);
    EXPECT_EQ(RigId({.pair = *back, .tof = {}}), RigId({.pair = pair, .tof = {}}));
    if (model[0] != 't') continue;
    EXPECT_THAT(ErrorOf(left->lens),
                HasSubstr("distortion_model = thin_prism_fisheye: allowed is plumb_bob"));
  }
}

// 0.03 % is a tenth of a pixel at the edges of 480 rows, 1 % is 2.4 px.
TEST(FromRos, PixelsAreSquareUpToHalfARow) {
  const RectifiedPair pair = examples::Rig().pair;
  auto left = ToRosLeftInfo(Place(), pair);
  auto right = ToRosRightInfo(Place(), pair);
  left->p[5] *= 1.0003;
  EXPECT_THAT(ErrorOf(PairOf(*FromRosInfo(*left), *FromRosInfo(*right))),
              HasSubstr("right p[5] = 500: allowed is that of the left camera"));
  right->p[5] *= 1.0003;
  EXPECT_TRUE(PairOf(*FromRosInfo(*left), *FromRosInfo(*right)));
  left->p[5] *= 1.01;
  EXPECT_THAT(ErrorOf(PairOf(*FromRosInfo(*left), *FromRosInfo(*right))),
              HasSubstr("left p[5] = 505.15"));
}

TEST(FromRos, RefusesCamerasThatAreNotCalibrated) {
  auto info = ToRosLeftInfo(Place(), examples::Rig().pair);
  info->p[0] = 0;
  EXPECT_THAT(ErrorOf(FromRosInfo(*info)), HasSubstr("p[0] = 0: allowed is a focal length > 0"));
  info = ToRosLeftInfo(Place(), examples::Rig().pair);
  info->k[0] = 0;
  EXPECT_THAT(ErrorOf(FromRosInfo(*info)->lens), HasSubstr("k[0] = 0: allowed is a focal length"));
  info = ToRosLeftInfo(Place(), examples::Rig().pair);
  info->r[0] = -1;
  EXPECT_THAT(ErrorOf(FromRosInfo(*info)), HasSubstr("r = no rotation"));
  info = ToRosLeftInfo(Place(), examples::Rig().pair);
  info->p[3] = NAN;
  EXPECT_THAT(ErrorOf(FromRosInfo(*info)), HasSubstr("p = not finite"));
}

TEST(FromRos, NamesTheFieldThatIsWrong) {
  auto info = ToRosLeftInfo(Place(), examples::Rig().pair);
  info->k[4] = 0;
  EXPECT_THAT(ErrorOf(FromRosInfo(*info)->lens), HasSubstr("k[4] = 0: allowed is"));
  info->p[5] = 0;
  EXPECT_THAT(ErrorOf(FromRosInfo(*info)), HasSubstr("p[5] = 0: allowed is a focal length > 0"));
  info = ToRosLeftInfo(Place(), examples::Rig().pair);
  info->p[1] = 52.4;  // OAK: the camera matrix times R
  EXPECT_THAT(ErrorOf(FromRosInfo(*info)), HasSubstr("p[1] = 52.4: allowed is 0"));
  info = ToRosLeftInfo(Place(), examples::Rig().pair);
  info->roi.y_offset = 20;
  info->roi.height = info->height;
  EXPECT_THAT(ErrorOf(FromRosInfo(*info)), HasSubstr("roi.y_offset = 20: allowed is a part of"));
}

TEST(FromRos, ABinnedOrCroppedImageHasItsPartOfTheCalibration) {
  auto info = ToRosLeftInfo(Place(), examples::Rig().pair);
  const uint32_t width = info->width;
  info->roi.x_offset = 40;
  info->roi.width = width - 40;
  info->binning_x = 2;
  info->binning_y = 2;
  info->p[3] = -60;
  const Result<RosCamera> camera = FromRosInfo(*info);
  ASSERT_TRUE(camera) << ErrorOf(camera);
  EXPECT_EQ(camera->size(),
            cv::Size(static_cast<int>((width - 40) / 2), static_cast<int>(info->height / 2)));
  EXPECT_EQ(camera->focal_px, info->p[0] / 2);
  EXPECT_EQ(camera->cx, (info->p[2] - 40) / 2);
  EXPECT_EQ(camera->cy, info->p[6] / 2);
  EXPECT_EQ(camera->tx, -30);
  ASSERT_TRUE(camera->lens);
  EXPECT_EQ(camera->lens->fy, info->k[4] / 2);
  EXPECT_EQ(camera->lens->cx, (info->k[2] - 40) / 2);
  info->roi.width = width;
  EXPECT_THAT(ErrorOf(FromRosInfo(*info)), HasSubstr("roi.x_offset = 40: allowed is a part of"));
}

TEST(FromRos, APairWithoutABaselineIsNoneThatIsSwapped) {
  const auto info = ToRosLeftInfo(Place(), examples::Rig().pair);
  EXPECT_THAT(ErrorOf(PairOf(*FromRosInfo(*info), *FromRosInfo(*info))),
              HasSubstr("no baseline is known of cameras that were calibrated one by one"));
}

TEST(FromRos, TakesARectificationThatIsLeftOutOrRounded) {
  auto info = ToRosLeftInfo(Place(), examples::Rig().pair);
  for (double& r : info->r) r = 0;
  EXPECT_TRUE(FromRosInfo(*info)->rectification.isIdentity(0));
  const double rounded[] = {1, -0.0005, 0.002, 0.0005, 1, -0.001, -0.002, 0.001, 1};
  std::ranges::copy(rounded, info->r);
  const auto camera = FromRosInfo(*info);
  ASSERT_TRUE(camera) << ErrorOf(camera);
  EXPECT_TRUE((camera->rectification * camera->rectification.transpose()).isIdentity(1e-12));
}

// OpenCV's rational model with the coefficients of Brown's alone is Brown's.
TEST(FromRos, ALensOfARationalModelMayBeBrowns) {
  const auto camera = FromRosInfo(*WithLens(*ToRosLeftInfo(Place(), examples::Rig().pair),
                                            "rational_polynomial", {1, 2, 3, 4, 5, 0, 0, 0}));
  ASSERT_TRUE(camera && camera->lens) << ErrorOf(camera->lens);
  EXPECT_EQ(camera->lens->distortion, (std::array<double, 5>{1, 2, 3, 4, 5}));
}

// Azure Kinect's and fisheye drivers' raw range images.
TEST(FromRos, ALensOfAnotherModelBecomesTheNearestOfBrowns) {
  const auto camera = [&](const std::string& model, double focal_px, const std::vector<double>& d) {
    auto info = WithLens(*ToRosTofInfo(Place(), examples::Rig().tof), model, d);
    info->width = 320;
    info->height = 240;
    info->k[0] = info->k[4] = focal_px;
    info->k[2] = 161;
    info->k[5] = 118;
    return FromRosInfo(*info)->lens;
  };
  const std::vector<cv::Point3d> points = {
      {0, 0, 1}, {0.4, 0.3, 1}, {-0.4, 0.2, 1}, {0.1, -0.3, 1}};
  const std::vector<double> rational = {0.3, -0.1, 1e-4, 2e-4, 0.01, 0.5, -0.1, 0.02};
  const std::vector<double> fisheye = {-0.02, 0.01, 0, 0};
  const cv::Matx33d square(300, 0, 161, 0, 300, 118, 0, 0, 1);
  for (const bool is_fisheye : {false, true}) {
    const Result<Lens> lens = is_fisheye ? camera("equidistant", 300, fisheye)
                                         : camera("rational_polynomial", 300, rational);
    ASSERT_TRUE(lens) << ErrorOf(lens);
    std::vector<cv::Point2d> places;
    const cv::Vec3d none(0, 0, 0);
    if (is_fisheye) {
      cv::fisheye::projectPoints(points, places, none, none, square, fisheye);
    } else {
      cv::projectPoints(points, none, none, square, rational, places);
    }
    for (size_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector2d ours = PixelOfDirection(*lens, {points[i].x, points[i].y});
      EXPECT_NEAR(ours.x(), places[i].x, 0.5) << i << is_fisheye;
      EXPECT_NEAR(ours.y(), places[i].y, 0.5) << i << is_fisheye;
    }
  }
  EXPECT_THAT(ErrorOf(camera("equidistant", 105, fisheye)),
              HasSubstr("px from any, 0.5 are allowed"));
  EXPECT_THAT(ErrorOf(camera("equidistant", 300, rational)),
              HasSubstr("d = 8: allowed is 4 coefficients of equidistant"));
}

TEST(FromRos, TheTofCameraComesBack) {
  const TofCamera tof = examples::Rig().tof;
  const auto info = FromRosInfo(*ToRosTofInfo(Place(), tof));
  ASSERT_TRUE(info) << ErrorOf(info);
  ASSERT_TRUE(info->lens) << ErrorOf(info->lens);
  EXPECT_EQ(info->lens->distortion, tof.distortion);
  const auto transforms = ToRosTransforms(1, examples::Rig(), {});
  const auto both = RosSpan(transforms->transforms);
  ASSERT_EQ(both.size(), 2U);
  const auto right = FromRosTransform(both[0]);
  ASSERT_TRUE(right) << ErrorOf(right);
  EXPECT_EQ(right->parent_from_child.translation_m, Eigen::Vector3d(0.125, 0, 0));
  const auto pose = FromRosTransform(both[1]);
  ASSERT_TRUE(pose) << ErrorOf(pose);
  EXPECT_EQ(pose->child, "sprout_tof_optical_frame");
  EXPECT_EQ(pose->parent_from_child.translation_m, tof.left_from_tof_translation_m);
  EXPECT_EQ(pose->parent_from_child.rotation.coeffs(), tof.left_from_tof_rotation.coeffs());
}

TEST(FromRos, ATransformThatCannotBeIsRefused) {
  const auto transforms = ToRosTransforms(1, examples::Rig(), {});
  RosTransform& one = RosSpan(transforms->transforms)[0];
  one.transform.translation.y = std::nan("");
  EXPECT_THAT(ErrorOf(FromRosTransform(one)), HasSubstr("transform.translation = not finite"));
  one.transform.rotation = {0, 0, 0, 0};
  EXPECT_THAT(ErrorOf(FromRosTransform(one)), HasSubstr("transform.rotation norm"));
}

}  // namespace
}  // namespace sprout
