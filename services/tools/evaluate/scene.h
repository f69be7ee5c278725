#ifndef SPROUT_SERVICES_TOOLS_EVALUATE_SCENE_H_
#define SPROUT_SERVICES_TOOLS_EVALUATE_SCENE_H_

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "common/geometry/projection.h"
#include "common/scenes/dataset.h"
#include "services/tools/evaluate/tof_choice.h"

namespace sprout::evaluate {

/// One frame with ground truth, ready to be run through methods.
struct Scene {
  std::string name;            ///< last part of the folder's path, or the source's text
  scenes::DatasetFrame frame;  ///< images, ToF image, truth
  cv::Mat1b left_grey;         ///< grey image, as used by the stages
  cv::Mat1b right_grey;
  TofProjector projector;  ///< knows the rig
  cv::Mat1b nonoccluded;   ///< the data set's mask, else NonOccludedMask() of its maps
  cv::Mat1b occluded;      ///< pixels that a nearer surface hides from the right camera
  cv::Mat1b away;          ///< 255 = at least kAwayPx from every ToF point
  bool truth_is_scan;      ///< KITTI: beside a ToF point the truth is the point itself
  int max_disparity_px;    ///< largest true disparity, rounded up

  cv::Size size() const { return left_grey.size(); }

  /// Refinement as a user would configure it for the scene's camera: with its unambiguous range,
  /// unless `config` has one.
  RefineConfig WithRange(RefineConfig config) const;
};

/// Where ground truth comes from the range sensor itself (KITTI), pixels nearer than this to a
/// point that a method was given test nothing, px.
inline constexpr double kAwayPx = 3;

/// Whether the scene is in KITTI's layout ("kitti:…"), which has a recorded scan.
bool IsKitti(const std::string& scene);

/// The scenes of one argument: all frames of kitti:DIR, otherwise the scene itself.
/// @throws ConfigError when there is none.
std::vector<std::string> ScenesOf(const std::string& scene);

/// Loads frame 0 of a scene.
///
/// @param scene   a Middlebury folder, or a source of capture's that starts with "synthetic:" or
///                "kitti:"; options behind a '?' (?tof=sr4000&blind=50) override `tof`.
/// @param config  its source and ToF camera are replaced.
/// @throws ConfigError naming what is missing or wrong, and where.
Scene LoadScene(const std::string& scene, const TofChoice& tof, CaptureConfig config);

}  // namespace sprout::evaluate

#endif  // SPROUT_SERVICES_TOOLS_EVALUATE_SCENE_H_
