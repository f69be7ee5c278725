#ifndef SPROUT_SERVICES_TOOLS_EVALUATE_RUN_PICTURES_H_
#define SPROUT_SERVICES_TOOLS_EVALUATE_RUN_PICTURES_H_

#include <filesystem>
#include <string>
#include <vector>

#include "services/tools/evaluate/evaluate.h"
#include "services/tools/evaluate/figure.h"

namespace sprout::evaluate {

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

#endif  // SPROUT_SERVICES_TOOLS_EVALUATE_RUN_PICTURES_H_
