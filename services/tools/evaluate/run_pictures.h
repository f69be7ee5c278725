#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "common/picture/color_scale.h"
#include "services/tools/evaluate/evaluate.h"

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

/// The pictures of a run: SCENE_METHOD.png for every map, and figure.png with the left image, all
/// maps, ground truth and the per cent of correct non-occluded pixels below each, a row for each
/// scene. The maps of a scene share one colour scale. errors.png has the points of the ToF camera
/// and the errors of the maps instead, from 0 to kLargestErrorPx; pixels that are not scored are
/// dark, those without a disparity have the largest error.
class RunPictures {
 public:
  explicit RunPictures(std::filesystem::path folder) : folder_(std::move(folder)) {}

  /// Writes the pictures of a scene. @throws std::runtime_error naming path and reason.
  void Add(const Scene& scene, const SceneResult& result);

  /// Writes figure.png and errors.png of the scenes added; all must have run the same methods.
  /// @throws std::runtime_error naming path and reason.
  void WriteFigures() const;

 private:
  std::filesystem::path folder_;
  std::vector<std::string> titles_;
  std::vector<std::string> error_titles_;
  std::vector<FigureRow> rows_;
  std::vector<FigureRow> error_rows_;
};

}  // namespace sprout::evaluate
