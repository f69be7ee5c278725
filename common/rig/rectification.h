#pragma once

#include <opencv2/core.hpp>
#include <string>

#include "common/core/rig.h"
#include "common/rig/raw_rig.h"

namespace sprout {

/// The rotations of both cameras, and the rectified cameras. Bouguet's method, as in
/// cv::stereoRectify, zoomed until there is no empty border.
struct Rectification {
  cv::Matx33d left_turn;  ///< from the camera's frame to the rectified one
  cv::Matx33d right_turn;
  RectifiedPair pair;
};

/// @pre the numbers of both lenses and of the baseline are finite and positive. O(1).
Rectification RectificationOf(const RawRig& rig);

/// The rig after rectification: the pair, and the ToF camera in its frame. O(1).
Rig RectifiedRig(const RawRig& rig, const Rectification& rectification);

/// Position in the rectified image of a pixel of the unrectified one.
/// @param cx  the rectified camera's principal point.
cv::Point2d RectifiedPixel(const Lens& lens, const cv::Matx33d& turn, const RectifiedPair& pair,
                           double cx, const cv::Point2d& raw_pixel);

/// Position in the unrectified image of a pixel (u, v) of the rectified one.
/// @param back  from the rectified frame to the camera's.
Eigen::Vector2d RawPixel(const Lens& lens, const Eigen::Matrix3d& back, const RectifiedPair& pair,
                         double cx, double u, double v);

/// From the rectified frame to the camera's: the inverse of a rotation.
Eigen::Matrix3d BackOf(const cv::Matx33d& turn);

/// How much the rectified views show, shares from 0 to 1.
struct RectifiedViews {
  double rows = 0;    ///< rows that both cameras see, as share of those of the camera with fewer
  double kept = 0;    ///< share of a camera's pixels that remain; the smaller of both cameras
  double filled = 0;  ///< share of rectified pixels that the camera saw; the smaller of both
};

/// O(1): some hundred pixels are sampled.
RectifiedViews ViewsOf(const RawRig& rig, const Rectification& rectification);

/// A warning about them, one line; empty when all is well.
std::string ViewsWarning(const RectifiedViews& views);

}  // namespace sprout
