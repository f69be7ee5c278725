#ifndef SPROUT_COMMON_RIG_RECTIFICATION_H_
#define SPROUT_COMMON_RIG_RECTIFICATION_H_

#include <opencv2/core.hpp>
#include <string>

#include "common/core/rig.h"
#include "common/rig/raw_rig.h"

namespace sprout {

/// How both cameras are turned, and what they are then. Bouguet's method, as in cv::stereoRectify,
/// zoomed until there is no border without a picture.
struct Rectification {
  cv::Matx33d left_turn;  ///< from the camera's frame to the rectified one
  cv::Matx33d right_turn;
  RectifiedPair pair;
};

/// @pre the numbers of both lenses and of the baseline are finite and positive. O(1).
Rectification RectificationOf(const RawRig& rig);

/// Pixel of the rectified image at which a pixel of the unrectified one lands.
/// @param cx  the rectified camera's principal point.
cv::Point2d RectifiedPixel(const Lens& lens, const cv::Matx33d& turn, const RectifiedPair& pair,
                           double cx, const cv::Point2d& raw_pixel);

/// Pixel of the unrectified image that a pixel (u, v) of the rectified one shows.
/// @param back  from the rectified frame to the camera's.
Eigen::Vector2d RawPixel(const Lens& lens, const Eigen::Matrix3d& back, const RectifiedPair& pair,
                         double cx, double u, double v);

/// From the rectified frame to the camera's: the inverse of a turn.
Eigen::Matrix3d BackOf(const cv::Matx33d& turn);

/// What the rectified views show, shares from 0 to 1.
struct RectifiedViews {
  double rows = 0;    ///< rows that both cameras see, of the fewer ones that one of them sees
  double kept = 0;    ///< of the pixels of a camera, those that are still there; the lesser share
  double filled = 0;  ///< of the rectified pixels, those that the camera saw; the lesser share
};

/// O(1): some hundred pixels are looked at.
RectifiedViews ViewsOf(const RawRig& rig, const Rectification& rectification);

/// What people should know of them, one line; empty when all is well.
std::string ViewsWarning(const RectifiedViews& views);

}  // namespace sprout

#endif  // SPROUT_COMMON_RIG_RECTIFICATION_H_
