#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/core/disparity_image.h"
#include "common/core/result.h"
#include "common/core/rig.h"
#include "common/core/seed.h"
#include "common/core/tof_image.h"

namespace sprout {

/// Projects a point of the left rectified frame (m) into both images: d = u − u' (paper, II-A).
/// @pre point_in_left.z() > 0.
Seed ProjectToPair(const RectifiedPair& pair, const Eigen::Vector3d& point_in_left);

/// The point in the left rectified frame (m) of a correspondence: the inverse of ProjectToPair().
Eigen::Vector3d PointFromSeed(const RectifiedPair& pair, const Seed& seed);

/// The point at a pixel with a disparity, as PointFromSeed() gives that of a seed. @pre
/// map.IsValid(u, v).
Eigen::Vector3d PointAt(const RectifiedPair& pair, const DisparityImage& map, int u, int v);

/// Depth z of a disparity map, m; NaN where there is no disparity, or one without a positive depth.
/// O(pixels).
cv::Mat1f DepthMap(const RectifiedPair& pair, const DisparityImage& disparity);

/// Standard deviations of these depths, m; NaN where there is no depth, infinite where that of the
/// disparity is 15.94 px or more. O(pixels).
/// @param sigma  of the map's size, counts as in PriorMap.
cv::Mat1f DepthSigmaMap(const RectifiedPair& pair, const DisparityImage& disparity,
                        const cv::Mat1b& sigma);

/// The same camera with images of `size`: the corners of both images coincide.
TofCamera Resized(TofCamera camera, cv::Size size);

/// A ToF camera of `size` in the left camera's place with its field of view: the corners of both
/// images coincide. For range images that are registered to the left image already.
TofCamera TofOverLeft(const RectifiedPair& pair, cv::Size size);

/// The calibration of one frame: if its ToF image is empty (0×0), without a ToF camera.
Rig RigOfFrame(const Rig& rig, const TofImage& tof);

/// Whether a range image has the calibrated ToF camera's size; the error names both. Check before
/// making a TofProjector, which allocates memory by the calibration's size.
Result<void> CheckTofSize(const Rig& rig, const TofImage& tof);

/// A ToF point seen in the rectified pair.
struct ProjectedPoint {
  int tof_u = 0;  ///< column in the ToF image
  int tof_v = 0;  ///< row in the ToF image
  Seed seed;      ///< has this pixel as tof_u and tof_v; may lie outside the images
};

/// Transforms the points of a ToF camera to the left rectified frame and projects them into the
/// pair. The undistorted viewing rays are computed once, so keep the object as long as the
/// calibration. Thread-compatible.
class TofProjector {
 public:
  /// O(ToF pixels), 24 bytes each.
  explicit TofProjector(const Rig& rig);

  /// Every ToF pixel with a return, see IsReturn(), that lies in front of the pair, row by row.
  /// @param tof  depth of the calibrated size, see CheckTofSize().
  /// @param[out] behind  number of points with a return that lie behind the pair (z ≤ 0).
  /// @param memory  a vector whose memory is reused.
  /// O(ToF pixels).
  std::vector<ProjectedPoint> Project(const TofImage& tof, int& behind,
                                      std::vector<ProjectedPoint> memory = {}) const;

  /// Direction of a ToF pixel in the ToF camera's frame, scaled to z = 1.
  const Eigen::Vector3d& ray(int tof_u, int tof_v) const {
    return rays_[static_cast<size_t>(tof_v) * static_cast<size_t>(rig_.tof.width) +
                 static_cast<size_t>(tof_u)];
  }

  const Rig& rig() const { return rig_; }

 private:
  Rig rig_;
  std::vector<Eigen::Vector3d> rays_;
};

}  // namespace sprout
