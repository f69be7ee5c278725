#include "tests/common/rig/kitti_raw.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <opencv2/calib3d.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "common/core/quantile.h"
#include "common/rig/rectifier.h"

namespace sprout {
namespace {

namespace fs = std::filesystem;

// KITTI's own rectification of a picture.
cv::Mat1b AsKittiDoes(const cv::Mat1b& image, const KittiValues& values,
                      const std::string& camera) {
  const auto matrix = [&](const std::string& key, int rows, int cols) {
    return cv::Mat(rows, cols, CV_64F, const_cast<double*>(values.at(key + camera).data())).clone();
  };
  cv::Mat map1;
  cv::Mat map2;
  cv::initUndistortRectifyMap(matrix("K_", 3, 3), matrix("D_", 1, 5), matrix("R_rect_", 3, 3),
                              matrix("P_rect_", 3, 4), {1242, 375}, CV_32FC1, map1, map2);
  cv::Mat1b rectified;
  cv::remap(image, rectified, map1, map2, cv::INTER_LINEAR);
  return rectified;
}

// How many rows further down the right image has what the left one shows, in the median over SIFT's
// keypoints.
double MedianRowOffset(const cv::Mat1b& left, const cv::Mat1b& right) {
  const auto sift = cv::SIFT::create(2000);
  std::vector<cv::KeyPoint> in_left;
  std::vector<cv::KeyPoint> in_right;
  cv::Mat of_left;
  cv::Mat of_right;
  sift->detectAndCompute(left, cv::noArray(), in_left, of_left);
  sift->detectAndCompute(right, cv::noArray(), in_right, of_right);
  std::vector<std::vector<cv::DMatch>> matches;
  cv::BFMatcher(cv::NORM_L2).knnMatch(of_left, of_right, matches, 2);
  std::vector<double> offsets;
  for (const auto& candidates : matches) {
    const cv::DMatch& best = candidates[0];
    if (best.distance > 0.7F * candidates[1].distance) continue;
    const cv::Point2f a = in_left[static_cast<size_t>(best.queryIdx)].pt;
    const cv::Point2f b = in_right[static_cast<size_t>(best.trainIdx)].pt;
    // Further away it is another thing.
    if (a.x > b.x && std::abs(a.y - b.y) < 5) offsets.push_back(b.y - a.y);
  }
  EXPECT_GT(offsets.size(), 200U);
  if (offsets.empty()) return NAN;
  return Median(offsets);
}

// Real lenses, real pictures, somebody else's calibration.
TEST(KittiRaw, HasBothImagesOfAPointOnOneRowOnceItIsRectified) {
  const char* data = std::getenv("SPROUT_DATA");
  const fs::path folder = fs::path(data == nullptr ? "" : data) / "kitti_raw";
  if (!fs::exists(folder)) GTEST_SKIP() << "SPROUT_DATA is not set, or has no kitti_raw";
  const KittiValues values = ReadKittiValues(folder / "calib_cam_to_cam.txt");
  const Rectifier rectifier(KittiRig(values));
  for (const int number : {336, 338, 340}) {
    const std::string name = "0000000" + std::to_string(number) + "_cam";
    const cv::Mat1b left = cv::imread(folder / (name + "0.png"), cv::IMREAD_GRAYSCALE);
    const cv::Mat1b right = cv::imread(folder / (name + "1.png"), cv::IMREAD_GRAYSCALE);
    ASSERT_FALSE(left.empty() || right.empty()) << name;
    // At KITTI's focal length.
    const double ours =
        MedianRowOffset(rectifier.RectifyLeft(left), rectifier.RectifyRight(right)) *
        values.at("P_rect_00")[0] / rectifier.rig().pair.focal_px;
    const double kittis =
        MedianRowOffset(AsKittiDoes(left, values, "00"), AsKittiDoes(right, values, "01"));
    std::cout << name << ": " << ours << " px, KITTI's own " << kittis << " px\n";
    // The calibration itself is half a row off in this recording: KITTI's own pictures show it,
    // too.
    EXPECT_LT(std::abs(ours), std::abs(kittis) + 0.1) << name;
  }
}

}  // namespace
}  // namespace sprout
