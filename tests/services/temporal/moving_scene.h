#pragma once

#include <opencv2/core.hpp>

#include "common/core/camera_motion.h"
#include "common/core/disparity_image.h"
#include "common/core/rig.h"
#include "services/temporal/temporal_filter.h"

namespace sprout::temporal {

/// A textured wall with a textured board in front of it, seen by a camera that moves; exact truth.
struct MovingScene {
  RectifiedPair pair;
  cv::Mat1b left;   ///< what the left camera sees
  cv::Mat1f truth;  ///< its disparities, px
};

/// @param world_from_left  pose of the camera; the wall stands at z = 4 m, the board at 2 m.
MovingScene SceneFrom(const Pose& world_from_left, cv::Size size = {320, 240});

/// A pose without rotation, but for a turn about y, rad.
Pose MovedBy(double x_m, double y_m, double z_m, double turn = 0);

/// A frame of the scene with Gaussian noise on its disparities, the same for the same `seq`.
TemporalInput FrameFrom(const MovingScene& scene, int64_t seq, double noise_px);

/// Mean |d − truth| of the pixels at least 4 px from the border, px; no disparity counts as 50.
double ErrorOf(const DisparityImage& disparity, const MovingScene& scene);

}  // namespace sprout::temporal
