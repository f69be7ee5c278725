#ifndef SPROUT_SERVICES_REFINE_STEREO_DISPARITY_BOUNDS_H_
#define SPROUT_SERVICES_REFINE_STEREO_DISPARITY_BOUNDS_H_

#include <opencv2/core.hpp>

namespace sprout::refine {

/// Disparities that surfaces can have in each cell of a CellGrid, by a range sensor that sees areas.
struct DisparityBounds {
  double spacing_px = 1;  ///< side of a cell, px
  cv::Mat1f least_px;     ///< of each cell; −infinity: not known
  cv::Mat1f most_px;      ///< infinity: not known

  bool empty() const { return least_px.empty(); }
};

}  // namespace sprout::refine

#endif  // SPROUT_SERVICES_REFINE_STEREO_DISPARITY_BOUNDS_H_
