#ifndef SPROUT_SERVICES_TOOLS_EVALUATE_FIGURE_H_
#define SPROUT_SERVICES_TOOLS_EVALUATE_FIGURE_H_

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "common/picture/color_scale.h"

namespace sprout::evaluate {

/// A picture in a figure, with a line of text below it.
struct FigureCell {
  cv::Mat3b image;
  std::string caption;  ///< ASCII
};

/// A row of pictures with one colour scale.
struct FigureRow {
  std::vector<FigureCell> cells;
  ScaleContent scale;
};

/// Many small pictures on one white sheet, as the paper's figure: a title above each column, a row
/// for each scene, its scale at the end.
///
/// @param titles  one a column, ASCII; written smaller when wider than the column.
/// @param rows    each with as many cells as titles; the images of a row have one size.
/// @returns pictures scaled to kFigureCellWidth. O(pixels).
cv::Mat3b Figure(const std::vector<std::string>& titles, const std::vector<FigureRow>& rows);

inline constexpr int kFigureCellWidth = 320;  ///< px

/// The image scaled for a figure, to keep instead of the original.
cv::Mat3b FigureThumbnail(const cv::Mat3b& image);

}  // namespace sprout::evaluate

#endif  // SPROUT_SERVICES_TOOLS_EVALUATE_FIGURE_H_
