#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "common/rig/rectifier.h"

namespace sprout {
namespace {

namespace fs = std::filesystem;

// The "key: numbers" lines of calib_cam_to_cam.txt.
std::map<std::string, std::vector<double>> Calibration(const fs::path& path) {
  std::map<std::string, std::vector<double>> values;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    const size_t colon = line.find(':');
    std::istringstream numbers(line.substr(colon + 1));
    for (double number = 0; numbers >> number;) values[line.substr(0, colon)].push_back(number);
  }
  return values;
}

using Values = std::map<std::string, std::vector<double>>;

Lens LensOf(const Values& values, const std::string& camera) {
  const std::vector<double>& k = values.at("K_" + camera);
  const std::vector<double>& size = values.at("S_" + camera);
  Lens lens{.width = static_cast<int>(size[0]),
            .height = static_cast<int>(size[1]),
            .fx = k[0],
            .fy = k[4],
            .cx = k[2],
            .cy = k[5]};
  std::copy_n(values.at("D_" + camera).begin(), lens.distortion.size(), lens.distortion.begin());
  return lens;
}

// Cameras 0 and 1, whose pictures are grey. KITTI gives camera 0 in camera 1's frame.
RawRig KittiRig(const Values& values) {
  RawRig rig;
  rig.left = LensOf(values, "00");
  rig.right = LensOf(values, "01");
  const Eigen::Matrix3d right_from_left =
      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(values.at("R_01").data());
  const Eigen::Map<const Eigen::Vector3d> translation(values.at("T_01").data());
  rig.left_from_right.rotation =
      Eigen::Quaterniond(Eigen::Matrix3d(right_from_left.transpose())).normalized();
  rig.left_from_right.translation_m = -right_from_left.transpose() * translation;
  return rig;
}

// KITTI's own rectification of a picture.
cv::Mat1b AsKittiDoes(const cv::Mat1b& image, const Values& values, const std::string& camera) {
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

// How many rows corners of the left image are away from theirs in the right one, in the median:
// Lucas and Kanade's tracker, there and back.
double MedianRowDifference(const cv::Mat1b& left, const cv::Mat1b& right) {
  std::vector<cv::Point2f> corners;
  cv::goodFeaturesToTrack(left, corners, 2000, 0.01, 8);
  std::vector<cv::Point2f> matches;
  std::vector<cv::Point2f> back;
  std::vector<uchar> found;
  std::vector<uchar> found_back;
  std::vector<float> error;
  const cv::Size window(15, 15);
  cv::calcOpticalFlowPyrLK(left, right, corners, matches, found, error, window, 5);
  cv::calcOpticalFlowPyrLK(right, left, matches, back, found_back, error, window, 5);
  std::vector<double> differences;
  for (size_t i = 0; i < corners.size(); ++i) {
    const bool same = found[i] && found_back[i] && cv::norm(back[i] - corners[i]) < 0.3;
    if (same && corners[i].x > matches[i].x) {
      differences.push_back(std::abs(matches[i].y - corners[i].y));
    }
  }
  EXPECT_GT(differences.size(), 200U);
  if (differences.empty()) return NAN;
  std::nth_element(differences.begin(), differences.begin() + std::ssize(differences) / 2,
                   differences.end());
  return differences[differences.size() / 2];
}

// Real lenses, real pictures, somebody else's calibration.
TEST(KittiRaw, HasBothImagesOfAPointOnOneRowOnceItIsRectified) {
  const char* data = std::getenv("SPROUT_DATA");
  const fs::path folder = fs::path(data == nullptr ? "" : data) / "kitti_raw";
  if (!fs::exists(folder)) GTEST_SKIP() << "SPROUT_DATA is not set, or has no kitti_raw";
  const Values values = Calibration(folder / "calib_cam_to_cam.txt");
  const Rectifier rectifier(KittiRig(values));
  int pairs = 0;
  for (int number = 336; number <= 341; ++number, ++pairs) {
    const std::string name = "0000000" + std::to_string(number) + "_cam";
    const cv::Mat1b left = cv::imread(folder / (name + "0.png"), cv::IMREAD_GRAYSCALE);
    const cv::Mat1b right = cv::imread(folder / (name + "1.png"), cv::IMREAD_GRAYSCALE);
    ASSERT_FALSE(left.empty() || right.empty()) << name;
    const double ours =
        MedianRowDifference(rectifier.RectifyLeft(left), rectifier.RectifyRight(right));
    const double kittis =
        MedianRowDifference(AsKittiDoes(left, values, "00"), AsKittiDoes(right, values, "01"));
    std::cout << name << ": " << ours << " px, KITTI's own " << kittis << " px\n";
    EXPECT_LT(ours, 0.3) << name;
    EXPECT_LT(ours, kittis + 0.1) << name;
  }
  EXPECT_EQ(pairs, 6);
}

}  // namespace
}  // namespace sprout
