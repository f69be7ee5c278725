#ifndef SPROUT_SERVICES_EVALUATE_SCENE_H_
#define SPROUT_SERVICES_EVALUATE_SCENE_H_

#include <opencv2/core.hpp>
#include <string>

#include "common/geometry/projection.h"
#include "services/capture/frame_source.h"
#include "services/evaluate/tof_choice.h"

namespace sprout {

/// One frame with ground truth, ready to be run through methods.
struct Scene {
  std::string name;     ///< last part of the folder's path, or the source's text
  CapturedFrame frame;  ///< images, ToF image, truth
  cv::Mat1b left_grey;  ///< the images as the stages look at them
  cv::Mat1b right_grey;
  TofProjector projector;  ///< knows the rig
  cv::Mat1b nonoccluded;   ///< NonOccludedMask() of the truth
  cv::Mat1b occluded;      ///< OccludedMask() of the truth
  int max_disparity_px;    ///< largest true disparity, rounded up

  cv::Size size() const { return left_grey.size(); }
};

/// Loads frame 0 of a scene.
///
/// @param scene   a Middlebury folder, or a source of capture's that starts with "synthetic:".
/// @param config  its source and ToF spacing are replaced.
/// @throws ConfigError naming what is missing or wrong, and where.
Scene LoadScene(const std::string& scene, const TofChoice& tof, CaptureConfig config);

}  // namespace sprout

#endif  // SPROUT_SERVICES_EVALUATE_SCENE_H_
