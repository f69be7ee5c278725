#ifndef SPROUT_SERVICES_CALIBRATE_SCENE_TOF_PATCHES_H_
#define SPROUT_SERVICES_CALIBRATE_SCENE_TOF_PATCHES_H_

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>

#include "common/geometry/projection.h"

namespace sprout::calibrate {

/// A plane through the ToF points around a place, in the ToF camera's frame: normal · x = distance.
struct TofPatch {
  Eigen::Vector3d normal{0, 0, 1};  ///< of length 1
  double distance_m = 0;
  double per_range = 1;  ///< change of distance_m for a range that is longer by 1 m: normal · ray
  double sigma_m = 0;    ///< of distance_m at the place, from the scatter of the points
};

/// Planes of a range image at places of the left image, away from depth edges.
class TofPatches {
 public:
  /// @param tof        of the calibrated size.
  /// @param projector  of the calibration; has to live as long.
  /// O(ToF pixels + left pixels / cell).
  TofPatches(const TofImage& tof, const TofProjector& projector);

  /// The plane through 5 × 5 ToF pixels around the one that is projected nearest to a place; nothing
  /// where there is none within a ToF pixel, where returns are missing, or where the points do not
  /// lie on one plane: beside a depth edge. O(1).
  std::optional<TofPatch> At(const cv::Point2d& left_px) const;

 private:
  const TofImage& tof_;
  const TofProjector& projector_;
  double cell_px_ = 1;  // a ToF pixel in the left image
  cv::Mat1i nearest_;   // index of a projected point in each cell, the nearest to the camera; −1
  std::vector<ProjectedPoint> points_;
};

}  // namespace sprout::calibrate

#endif  // SPROUT_SERVICES_CALIBRATE_SCENE_TOF_PATCHES_H_
