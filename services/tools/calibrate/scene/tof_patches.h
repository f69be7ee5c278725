#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "common/geometry/projection.h"

namespace sprout::calibrate {

/// A plane through the ToF points around a place, in the ToF camera's frame: normal · x = distance.
struct TofPatch {
  Eigen::Vector3d normal{0, 0, 1};  ///< of length 1
  double distance_m = 0;
  double per_range = 1;  ///< change of distance_m for a range that is longer by 1 m: normal · ray
  double sigma_m = 0;    ///< of distance_m at the place, from the scatter of the points
  double amplitude = 0;  ///< mean of the points, in the sensor's unit; 0: not known
};

/// Planes of a range image at places of the left image, away from depth edges.
class TofPatches {
 public:
  /// @param tof  of the calibrated size; a coarse or scattered one (lidar) as well.
  /// O(ToF pixels).
  TofPatches(const TofImage& tof, const TofProjector& projector);

  /// The plane through the points in a square of five times their mean spacing around a place:
  /// nothing where there are few, or where they do not lie on one plane: beside a depth edge, or on
  /// a ball. O(1).
  std::optional<TofPatch> At(const cv::Point2d& left_px) const;

 private:
  struct Point {
    cv::Point2d left_px;
    Eigen::Vector3d in_tof;
    double amplitude = 0;
  };

  cv::Point CellOf(const cv::Point2d& left_px) const {
    return {static_cast<int>(left_px.x / spacing_px_), static_cast<int>(left_px.y / spacing_px_)};
  }

  double spacing_px_ = 1;  // side of a cell: one point in each, in the mean
  cv::Size cells_;
  std::vector<std::vector<Point>> points_;  // in each cell, row by row
};

}  // namespace sprout::calibrate
