#pragma once

#include <cstdint>
#include <deque>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/core/camera_motion.h"
#include "common/core/rig.h"
#include "common/core/tof_image.h"

namespace sprout::evaluate {

/// Figures of the maps of a video; nothing for what cannot be said.
struct VideoFigures {
  double bad1_percent = 0;  ///< error > 1 px, or no disparity
  double bad3_percent = 0;
  double mean_px = 0;    ///< error, at most 50 px, which is that of no disparity
  double change_px = 0;  ///< mean of |Δd − Δd_gt| from frame to frame at one pixel, at most 20 px
  /// The same at one point of what stands still, where its truth is known then and now: mean of the
  /// change of its error, at most 20 px. Nothing where the camera's motion is not known.
  std::optional<double> along_px;
  std::optional<double> trail_percent;    ///< bad 3 where something nearer was in the last 3 frames
  std::optional<double> covered_percent;  ///< bad 3 where something nearer came
  /// Standard deviation of a pixel over the frames, px, in a scene that stands still.
  std::optional<double> flicker_median_px;
  std::optional<double> flicker_p95_px;
};

/// Scores the maps of a video, one method's. The first frames are not scored: the memory of a
/// filter fills.
class VideoScore {
 public:
  static constexpr int kFirstScored = 2;

  /// How the camera really moved since the frame before.
  struct TrueMotion {
    Pose left_from_last;
    RectifiedPair pair;
  };

  /// @param map_px, truth_px  NaN = none.
  /// @param mask              pixels to score.
  void Add(const cv::Mat1f& map_px, const cv::Mat1f& truth_px, const cv::Mat1b& mask,
           const std::optional<TrueMotion>& motion = {});

  VideoFigures figures() const;

 private:
  struct Share {
    int64_t pixels = 0, bad = 0;
    std::optional<double> percent() const;
  };
  void AddErrors(const cv::Mat1f& map, const cv::Mat1f& truth, const cv::Mat1b& mask);
  void AddChanges(const cv::Mat1f& map, const cv::Mat1f& truth, const cv::Mat1b& mask);
  void AddAlong(const cv::Mat1f& map, const cv::Mat1f& truth, const cv::Mat1b& mask,
                const TrueMotion& motion);
  void AddSpread(const cv::Mat1f& map);

  std::deque<cv::Mat1f> truths_;  // of the newest frames
  cv::Mat1f last_map_;
  int frames_ = 0;
  bool still_ = true;  // the truth has not changed yet
  Share bad1_, bad3_, trail_, covered_;
  double error_sum_ = 0, change_sum_ = 0;
  int64_t changes_ = 0;
  double along_sum_ = 0;
  int64_t alongs_ = 0;
  cv::Mat1d sums_, squares_;
};

/// How far measured motions are from the true ones.
class MotionScore {
 public:
  void Add(const CameraMotion& measured, const Pose& true_left_from_last);

  int frames = 0;
  int resets = 0;         ///< without the first frame
  double way_m = 0;       ///< true
  double error_m = 0;     ///< sum over the frames
  double largest_m = 0;   ///< error of a frame
  double turn_error = 0;  ///< rad, sum
};

/// How the left camera really moved: of each frame, its frame then, seen from now.
///
/// kitti:FOLDER: FOLDER/poses.txt as KITTI's odometry set has it: a row a frame, the 3×4 pose of
/// camera 0 in the world, row by row; the left camera's place beside camera 0 is that of P2 in
/// calib/. Other sources stand still, and have one standstill for all frames.
/// @returns empty when there is no poses.txt.
/// @throws ConfigError for one that cannot be read.
std::vector<Pose> TrueMotions(const std::string& source, int frames);

/// Pixels at least 3 px from every ToF point of a frame and of the two frames before it, moved to
/// where they are now: a filter knows those as well.
class AwayFromPoints {
 public:
  /// @param left_from_last  how the left camera moved.
  cv::Mat1b Add(const TofImage& tof, const Rig& rig, const Pose& left_from_last);

 private:
  std::deque<std::vector<Eigen::Vector3d>> points_m_;  // of the newest frames, in the left frame
};

}  // namespace sprout::evaluate
