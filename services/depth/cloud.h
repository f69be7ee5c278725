#ifndef SPROUT_SERVICES_DEPTH_CLOUD_H_
#define SPROUT_SERVICES_DEPTH_CLOUD_H_

#include <opencv2/core.hpp>

#include "common/core/depth_image.h"
#include "common/core/disparity_image.h"
#include "common/core/pose.h"
#include "common/core/rig.h"

namespace sprout::depth {

/// How a cloud is thinned.
struct CloudThinning {
  int stride = 1;      ///< N: every N-th pixel of every N-th row
  double voxel_m = 0;  ///< keeps the first point in each cube of this side; 0 = all
};

/// Points of a disparity map, row by row, with the colours of the left image. Pixels without a
/// disparity, or without a finite positive depth, give none. At most kMaxCloudPoints. O(pixels /
/// stride²).
///
/// @param left        8UC1 or 8UC3 (BGR), of the map's size.
/// @param confidence  8UC1 of the map's size, or empty: 255 everywhere.
PointCloud CloudOf(const DisparityImage& disparity, const RectifiedPair& pair, const cv::Mat& left,
                   const cv::Mat& confidence, const CloudThinning& thinning);

/// The same points in another frame. O(points).
PointCloud Moved(PointCloud cloud, const Pose& other_from_left);

/// Colour of a pixel, BGR; of a grey image three times the same.
/// @param image  8UC1 or 8UC3 (BGR).
cv::Vec3b ColourAt(const cv::Mat& image, int u, int v);

}  // namespace sprout::depth

#endif  // SPROUT_SERVICES_DEPTH_CLOUD_H_
