#include "services/tools/evaluate/video_truth.h"

#include <filesystem>
#include <fstream>
#include <opencv2/imgproc.hpp>

#include "common/config/config_error.h"
#include "common/core/input_files.h"
#include "common/geometry/projection.h"
#include "common/scenes/kitti_calibration.h"
#include "common/scenes/kitti_source.h"
#include "services/tools/evaluate/scene.h"

namespace sprout::evaluate {
namespace {

namespace fs = std::filesystem;

constexpr size_t kFramesOfPoints = 3;
constexpr double kNearestPointM = 0.1;

Pose ReadPose(std::ifstream& file, const fs::path& path) {
  Eigen::Matrix3d rotation;
  Pose pose;
  for (Eigen::Index row = 0; row < 3; ++row) {
    for (Eigen::Index column = 0; column < 4; ++column) {
      double value = 0;
      if (!(file >> value)) {
        throw ConfigError("poses " + path.string() +
                          ": fewer than 12 numbers a frame; allowed: KITTI's odometry poses");
      }
      if (column < 3) {
        rotation(row, column) = value;
      } else {
        pose.translation_m[row] = value;
      }
    }
  }
  pose.rotation = Eigen::Quaterniond(rotation).normalized();
  return pose;
}

}  // namespace

std::vector<Pose> TrueMotions(const std::string& source, int frames) {
  if (!IsKitti(source)) return std::vector<Pose>(static_cast<size_t>(frames));
  const std::string first = ScenesOf(source).front();  // kitti:FOLDER/ID?…
  const size_t begin = first.find(':') + 1;
  const fs::path place = first.substr(begin, first.find('?') - begin);
  const fs::path path = place.parent_path() / "poses.txt";
  NoteInputFile(path);
  std::ifstream file(path);
  if (!file) return {};
  // The left camera stands in the frame of camera 0 where the scanner's calibration says, and is
  // turned as camera 0.
  const fs::path calibration = place.parent_path() / "calib" / (place.filename().string() + ".txt");
  Pose left_from_camera0;
  left_from_camera0.translation_m = scenes::ReadKittiLeftOffset(calibration);
  std::vector<Pose> motions(1);
  Pose last = ReadPose(file, path);
  while (std::ssize(motions) < frames) {
    const Pose now = ReadPose(file, path);
    motions.push_back(left_from_camera0 * now.Inverse() * last * left_from_camera0.Inverse());
    last = now;
  }
  return motions;
}

cv::Mat1b AwayFromPoints::Add(const TofImage& tof, const Rig& rig, const Pose& left_from_last) {
  for (std::vector<Eigen::Vector3d>& points : points_m_) {
    for (Eigen::Vector3d& point : points) {
      point = left_from_last.rotation * point + left_from_last.translation_m;
    }
  }
  std::vector<Eigen::Vector3d> points;
  if (!tof.depth_m.empty()) {
    int behind = 0;
    for (const ProjectedPoint& point : TofProjector(rig).Project(tof, behind)) {
      points.push_back(PointFromSeed(rig.pair, point.seed));
    }
  }
  points_m_.push_back(std::move(points));
  if (points_m_.size() > kFramesOfPoints) points_m_.pop_front();

  const RectifiedPair& pair = rig.pair;
  cv::Mat1b used(pair.size(), uint8_t{0});
  for (const auto& frame : points_m_) {
    for (const Eigen::Vector3d& point : frame) {
      if (!(point.z() > kNearestPointM)) continue;
      const cv::Point pixel(cvRound(pair.focal_px * point.x() / point.z() + pair.cx),
                            cvRound(pair.focal_px * point.y() / point.z() + pair.cy));
      if (cv::Rect({0, 0}, pair.size()).contains(pixel)) used(pixel) = 255;
    }
  }
  cv::Mat1b near, away;
  cv::dilate(used, near, cv::Mat1b(5, 5, uint8_t{1}));
  cv::bitwise_not(near, away);
  return away;
}

}  // namespace sprout::evaluate
