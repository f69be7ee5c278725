#ifndef SPROUT_SERVICES_TOOLS_EVALUATE_VIDEO_TRUTH_H_
#define SPROUT_SERVICES_TOOLS_EVALUATE_VIDEO_TRUTH_H_

#include <deque>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "common/core/camera_motion.h"
#include "common/core/rig.h"
#include "common/core/tof_image.h"

namespace sprout::evaluate {

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

#endif  // SPROUT_SERVICES_TOOLS_EVALUATE_VIDEO_TRUTH_H_
