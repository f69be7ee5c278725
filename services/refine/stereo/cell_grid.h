#ifndef SPROUT_SERVICES_REFINE_STEREO_CELL_GRID_H_
#define SPROUT_SERVICES_REFINE_STEREO_CELL_GRID_H_

#include <cmath>
#include <opencv2/core/types.hpp>

namespace sprout::refine {

/// Square cells over the left image.
struct CellGrid {
  double spacing_px;  ///< side of a cell, px
  cv::Size size;      ///< cells

  CellGrid(double spacing, cv::Size image)
      : spacing_px(spacing), size(At(image.width - 1) + 1, At(image.height - 1) + 1) {}

  /// The column or row of cells that a position lies in.
  int At(double position) const {
    return static_cast<int>(std::floor((position + 0.5) / spacing_px));
  }

  /// The middle of a cell, px of the image.
  cv::Point2d CentrePx(cv::Point cell) const {
    return {(cell.x + 0.5) * spacing_px - 0.5, (cell.y + 0.5) * spacing_px - 0.5};
  }
};

}  // namespace sprout::refine

#endif  // SPROUT_SERVICES_REFINE_STEREO_CELL_GRID_H_
