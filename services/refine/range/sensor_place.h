#pragma once

#include <opencv2/core.hpp>
#include <span>

#include "common/core/seed.h"
#include "common/geometry/projection.h"

namespace sprout::refine {

/// What stereo says of where a range sensor looks, and of its unit.
struct SensorPlace {
  /// Its points clearly fit better elsewhere in the picture, or in depth.
  bool is_displaced = false;
  /// What has to be added there to their positions in the left image.
  cv::Point2d move_px;
  /// Or by what their distances from its middle have to be multiplied: not 1 for a lens whose field
  /// of view is so many times as wide as calibrated.
  double spread = 1;
  /// Or by what their depths have to be divided: not 1 for a sensor of another unit or baseline.
  double scale = 1;
  /// Or, of a scan, what has to be added to u for each px further down: its rows are sheared.
  double shear = 0;
  /// Or, of a scan, they were projected for the right camera: their disparity has to be added to u.
  bool in_right_image = false;
  double agree_as_is = 0;  ///< share of the matches that agree with the points around them, 0 to 1
  double agree_moved = 0;  ///< the same with the points moved
  double gain_sigmas = 0;  ///< standard deviations of the difference

  /// Only moved in the left image.
  bool IsMove() const { return scale == 1 && spread == 1 && shear == 0 && !in_right_image; }
};

/// A frame's range points.
struct PlacedPoints {
  std::span<const ProjectedPoint> raw;        ///< as measured
  std::span<const ProjectedPoint> corrected;  ///< less what was found of their errors
  cv::Size2d spacing_px;                      ///< from one to the next in the left image
  cv::Size image;                             ///< the left one
  double infinity_px = 0;                     ///< disparity of infinity: cx − cx' of the pair
};

/// Asks whether a range sensor was turned or moved, or has another lens: whether its points, all
/// moved by one offset in the left image, spread about its middle or scaled in depth, fit the
/// disparities of stereo better than where they are, and better than after RangeBias, too.
/// @param matches   of stereo that knows nothing of the points.
/// @param agree_px  by which points and matches may differ where they agree.
/// @param strictness  1; less: for a first look.
/// O(points + matches): 725 places of 1000 matches. No I/O; one thread; the same on every machine.
SensorPlace FindSensorPlace(const PlacedPoints& points, std::span<const Seed> matches,
                            double agree_px, double strictness = 1);

/// The same of a lidar's scan. Its points are too far apart for matches to be compared with those
/// around, so each is compared with the match that it lies at when all are moved, sheared row by
/// row, or taken for points of the right image.
/// @param points   of the scan: raw and corrected ones in the same order.
/// @param matches  of stereo that knows nothing of the points, on a grid.
/// @param cell_px  from one match to the next, above 0.
/// O(points + matches): 400 places of 1000 points. No I/O; one thread; the same on every machine.
SensorPlace FindScanPlace(const PlacedPoints& points, std::span<const Seed> matches, double cell_px,
                          double agree_px, double strictness = 1);

}  // namespace sprout::refine
