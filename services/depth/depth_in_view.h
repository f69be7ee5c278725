#pragma once

#include <opencv2/core.hpp>

#include "common/core/depth_image.h"
#include "common/core/disparity_image.h"
#include "common/core/pose.h"
#include "common/core/rig.h"
#include "services/depth/cloud.h"

namespace sprout::depth {

/// A pinhole camera with square pixels, anywhere.
struct View {
  cv::Size size;        ///< px
  double focal_px = 0;  ///< > 0
  double cx = 0;        ///< principal point, px
  double cy = 0;
  Pose view_from_left;  ///< of the left rectified camera in this camera's frame
};

/// What a camera sees without its lens's distortion: its image size, fx and principal point.
/// @param left_from_camera  its pose in the left rectified frame.
View ViewOf(const Lens& lens, const Pose& left_from_camera);

/// Depth of a disparity map as another camera sees it, z along that camera's axis, in counts,
/// rounded to nearest. Pixels of the map whose disparities differ by at most 1 px from that of
/// their right, lower and lower right neighbour span a surface: it fills all pixels of the view
/// that lie on it, so that there are no holes. At its border a pixel of the map fills its own size.
/// The nearest surface wins (z-buffer). No depth where nothing is projected to, among them what the
/// camera sees and the map does not, as the back of what the map shows, nor beyond 65535 counts.
///
/// Rows in parallel; the same for any number of threads. O(pixels of the map and of the view).
///
/// @param pair  of the map's size.
/// @param view  sides of at most kMaxSide px.
/// @param metres_per_count  > 0.
DepthImage DepthInView(const DisparityImage& map, const RectifiedPair& pair, const View& view,
                       double metres_per_count);

/// Points of a depth image of DepthInView(), in the view's frame, row by row, with the colours and
/// confidences of the left image, each from the pixel nearest to the point's projection. At most
/// kMaxCloudPoints. O(pixels / stride²).
///
/// @param left        8UC1 or 8UC3 (BGR), of the pair's size.
/// @param confidence  8UC1 of the pair's size, or empty: 255 everywhere.
PointCloud CloudInView(const DepthImage& depth, const View& view, const RectifiedPair& pair,
                       const cv::Mat& left, const cv::Mat& confidence,
                       const CloudThinning& thinning);

}  // namespace sprout::depth
