#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "common/geometry/projection.h"
#include "services/refine/surface/tof_surface.h"

namespace sprout::refine {

/// A range image whose near surfaces reach beyond their edges, as those of cameras that match
/// windows, fill holes or are late.
struct Fattening {
  int width = 0;             ///< by how many ToF pixels at most; 0: they do not, or too few tell
  double dropped_share = 0;  ///< of the points, 0 to 1

  explicit operator bool() const { return width > 0; }
};

/// Drops points of near surfaces where the images show the farther surface that lies beside them:
/// at the edges first, then one pixel further in, as long as that is so at many points there.
/// @param left, right  the rectified pair, grey.
/// @param noise_px  of the points, one standard deviation: what noise makes is no edge.
/// @param points  those that the surface was made of; of a right sensor all stay.
/// @param before  gets the points as they were, if some are dropped.
/// O(ToF pixels · (1 + width)). No I/O; one thread.
Fattening DropFattened(const TofSurface& surface, const cv::Mat1b& left, const cv::Mat1b& right,
                       double noise_px, std::vector<ProjectedPoint>& points,
                       std::vector<ProjectedPoint>& before);

}  // namespace sprout::refine
