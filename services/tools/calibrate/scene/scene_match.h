#ifndef SPROUT_SERVICES_TOOLS_CALIBRATE_SCENE_SCENE_MATCH_H_
#define SPROUT_SERVICES_TOOLS_CALIBRATE_SCENE_SCENE_MATCH_H_

#include <Eigen/Core>
#include <cstddef>
#include <opencv2/core.hpp>
#include <optional>

#include "services/tools/calibrate/scene/tof_patches.h"

namespace sprout::calibrate {

/// A point of the scene in both unrectified images.
struct SceneMatch {
  size_t view = 0;
  cv::Point2d left;             ///< px
  cv::Point2d right;            ///< px
  double inverse_depth = 0;     ///< 1 / z in the left camera's frame, 1/m; > 0
  std::optional<TofPatch> tof;  ///< what the ToF camera measured there, away from depth edges
};

/// Where depth edges of the ToF camera lie in the images, of all views together: the turn that the
/// ToF camera needs besides one that was applied already.
struct EdgeShift {
  Eigen::Vector2d turn;     ///< about the rectified left camera's x and y axis, rad
  Eigen::Vector2d sigma;    ///< of either, rad
  Eigen::Vector3d applied;  ///< turn that was applied already, axes of the left camera, rad
  Eigen::Matrix3d rectified_from_left;
};

}  // namespace sprout::calibrate

#endif  // SPROUT_SERVICES_TOOLS_CALIBRATE_SCENE_SCENE_MATCH_H_
