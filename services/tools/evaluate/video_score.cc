#include "services/tools/evaluate/video_score.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <opencv2/imgproc.hpp>

#include "common/config/config_error.h"
#include "common/core/input_files.h"
#include "common/core/number_text.h"
#include "common/core/quantile.h"
#include "common/geometry/projection.h"
#include "common/scenes/kitti_calibration.h"
#include "services/tools/evaluate/scene.h"

namespace sprout::evaluate {
namespace {

constexpr double kNoDisparityPx = 50;
constexpr double kMaxChangePx = 20;
constexpr size_t kTrailFrames = 3;
constexpr double kNearestM = 0.1;  // nearer points are not compared, m
constexpr double kSamePx = 1;      // truths that differ by less are of the same surface, px
constexpr float kStepPx = 2;       // a larger step of the truth: something nearer came or went, px

double ErrorOf(float d, float truth) {
  if (!std::isfinite(d)) return kNoDisparityPx;
  return std::min(static_cast<double>(std::abs(d - truth)), kNoDisparityPx);
}

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

std::optional<double> VideoScore::Share::percent() const {
  if (pixels == 0) return std::nullopt;
  return 100.0 * static_cast<double>(bad) / static_cast<double>(pixels);
}

void VideoScore::Add(const cv::Mat1f& map, const cv::Mat1f& truth, const cv::Mat1b& mask,
                     const std::optional<TrueMotion>& motion) {
  if (!truths_.empty()) {
    const cv::Mat same = truths_.back() == truth;
    const cv::Mat known = truth == truth;
    still_ = still_ && cv::countNonZero(same) == cv::countNonZero(known);
  }
  if (frames_ >= kFirstScored) {
    AddErrors(map, truth, mask);
    AddChanges(map, truth, mask);
    if (motion) AddAlong(map, truth, mask, *motion);
    AddSpread(map);
  }
  truths_.push_back(truth);
  if (truths_.size() > kTrailFrames) truths_.pop_front();
  last_map_ = map;
  ++frames_;
}

void VideoScore::AddErrors(const cv::Mat1f& map, const cv::Mat1f& truth, const cv::Mat1b& mask) {
  for (int v = 0; v < map.rows; ++v) {
    for (int u = 0; u < map.cols; ++u) {
      if (mask(v, u) == 0 || !std::isfinite(truth(v, u))) continue;
      const double error = ErrorOf(map(v, u), truth(v, u));
      const int bad = error > 3 ? 1 : 0;
      ++bad1_.pixels;
      ++bad3_.pixels;
      bad1_.bad += error > 1 ? 1 : 0;
      bad3_.bad += bad;
      error_sum_ += error;
      float nearest = truths_.back()(v, u);
      if (truth(v, u) > nearest + kStepPx) {
        ++covered_.pixels;
        covered_.bad += bad;
      }
      for (const cv::Mat1f& earlier : truths_) nearest = std::max(nearest, earlier(v, u));
      if (truth(v, u) < nearest - kStepPx) {
        ++trail_.pixels;
        trail_.bad += bad;
      }
    }
  }
}

void VideoScore::AddChanges(const cv::Mat1f& map, const cv::Mat1f& truth, const cv::Mat1b& mask) {
  for (int v = 0; v < map.rows; ++v) {
    for (int u = 0; u < map.cols; ++u) {
      const float change = truth(v, u) - truths_.back()(v, u);
      if (mask(v, u) == 0 || !std::isfinite(change)) continue;
      const auto error = static_cast<double>(std::abs(map(v, u) - last_map_(v, u) - change));
      change_sum_ += std::isfinite(error) ? std::min(error, kMaxChangePx) : kMaxChangePx;
      ++changes_;
    }
  }
}

void VideoScore::AddAlong(const cv::Mat1f& map, const cv::Mat1f& truth, const cv::Mat1b& mask,
                          const TrueMotion& motion) {
  const RectifiedPair& pair = motion.pair;
  const Pose last_from_left = motion.left_from_last.Inverse();
  const cv::Mat1f& last_truth = truths_.back();
  for (int v = 0; v < map.rows; ++v) {
    for (int u = 0; u < map.cols; ++u) {
      if (mask(v, u) == 0 || !std::isfinite(truth(v, u))) continue;
      const double z = pair.DepthFromDisparity(static_cast<double>(truth(v, u)));
      if (!(z > 0) || !std::isfinite(z)) continue;
      const Eigen::Vector3d then =
          last_from_left.rotation * Eigen::Vector3d((u - pair.cx) / pair.focal_px * z,
                                                    (v - pair.cy) / pair.focal_px * z, z) +
          last_from_left.translation_m;
      if (!(then.z() > kNearestM)) continue;
      const double last_u = pair.focal_px * then.x() / then.z() + pair.cx;
      const double last_v = pair.focal_px * then.y() / then.z() + pair.cy;
      // The nearest pixel there is compared, but not where it shows another surface.
      if (!(last_u >= 0 && last_v >= 0 && last_u <= map.cols - 1 && last_v <= map.rows - 1)) {
        continue;
      }
      const cv::Point at(cvRound(last_u), cvRound(last_v));
      const double off = static_cast<double>(last_truth(at)) - pair.DisparityFromDepth(then.z());
      if (!(std::abs(off) < kSamePx)) continue;
      const auto error = static_cast<double>(
          std::abs((map(v, u) - truth(v, u)) - (last_map_(at) - last_truth(at))));
      along_sum_ += std::isfinite(error) ? std::min(error, kMaxChangePx) : kMaxChangePx;
      ++alongs_;
    }
  }
}

void VideoScore::AddSpread(const cv::Mat1f& map) {
  cv::Mat1d wide;  // a pixel that was NaN once stays NaN
  map.convertTo(wide, CV_64F);
  if (sums_.empty()) {
    sums_ = cv::Mat1d(map.size(), 0);
    squares_ = cv::Mat1d(map.size(), 0);
  }
  sums_ += wide;
  squares_ += wide.mul(wide);
}

VideoFigures VideoScore::figures() const {
  VideoFigures figures;
  figures.bad1_percent = bad1_.percent().value_or(NAN);
  figures.bad3_percent = bad3_.percent().value_or(NAN);
  figures.mean_px = error_sum_ / static_cast<double>(bad1_.pixels);
  figures.change_px = change_sum_ / static_cast<double>(changes_);
  if (alongs_ > 0) figures.along_px = along_sum_ / static_cast<double>(alongs_);
  figures.trail_percent = trail_.percent();
  figures.covered_percent = covered_.percent();
  const double frames = frames_ - kFirstScored;
  if (!still_ || frames < 2) return figures;
  std::vector<double> spreads;
  for (int v = 0; v < sums_.rows; ++v) {
    for (int u = 0; u < sums_.cols; ++u) {
      const double variance = (squares_(v, u) - sums_(v, u) * sums_(v, u) / frames) / (frames - 1);
      if (std::isfinite(variance)) spreads.push_back(std::sqrt(std::max(0.0, variance)));
    }
  }
  if (spreads.empty()) return figures;
  figures.flicker_median_px = OrderStatistic(std::span(spreads), spreads.size() / 2);
  figures.flicker_p95_px = OrderStatistic(std::span(spreads), spreads.size() * 95 / 100);
  return figures;
}

void MotionScore::Add(const CameraMotion& measured, const Pose& true_left_from_last) {
  if (measured.reset == MemoryReset::kFirst) return;
  if (measured.reset != MemoryReset::kNone) {
    ++resets;
    return;
  }
  const Pose difference = true_left_from_last * measured.last_from_left;
  const double error = difference.translation_m.norm();
  ++frames;
  way_m += true_left_from_last.translation_m.norm();
  error_m += error;
  largest_m = std::max(largest_m, error);
  turn_error += 2 * std::asin(std::min(1.0, difference.rotation.vec().norm()));
}

std::vector<Pose> TrueMotions(const std::string& source, int frames) {
  if (!IsKitti(source)) return std::vector<Pose>(static_cast<size_t>(frames));
  std::vector<fs::path> places;
  for (const std::string& scene : ScenesOf(source)) {  // kitti:FOLDER/ID?…
    const size_t begin = scene.find(':') + 1;
    places.emplace_back(scene.substr(begin, scene.find('?') - begin));
  }
  const fs::path folder = places.front().parent_path();
  const fs::path path = folder / "poses.txt";
  NoteInputFile(path);
  std::ifstream file(path);
  if (!file) return {};
  // The left camera stands in the frame of camera 0 where the scanner's calibration says, and is
  // turned as camera 0.
  fs::path calibration = folder / "calib" / (places.front().filename().string() + ".txt");
  if (!fs::exists(calibration)) calibration = folder / "calib.txt";
  Pose left_from_camera0;
  left_from_camera0.translation_m = scenes::ReadKittiLeftOffset(calibration);
  std::vector<Pose> poses;
  while (!(file >> std::ws).eof()) poses.push_back(ReadPose(file, path));
  // A row a frame that is there, or, of a part of a sequence, the row that is the frame's number.
  const bool by_order = poses.size() == places.size();
  const auto pose_of = [&](size_t i) {
    const std::optional<int64_t> row = by_order
                                           ? std::optional(static_cast<int64_t>(i))
                                           : ParseNumber<int64_t>(places[i].filename().string());
    if (row && *row >= 0 && *row < std::ssize(poses)) return poses[static_cast<size_t>(*row)];
    throw ConfigError("poses " + path.string() + ": " + std::to_string(poses.size()) +
                      " rows, and none is known to be that of " + places[i].string() +
                      "; allowed: a row for each frame, or for each number of a frame");
  };
  std::vector<Pose> motions(1);
  Pose last = pose_of(0);
  while (std::ssize(motions) < frames) {
    const Pose now = pose_of(motions.size());
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
