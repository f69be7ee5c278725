#ifndef SPROUT_SERVICES_TOOLS_EVALUATE_VISIBILITY_H_
#define SPROUT_SERVICES_TOOLS_EVALUATE_VISIBILITY_H_

#include <opencv2/core.hpp>

#include "common/scenes/dataset.h"

namespace sprout::evaluate {

/// Pixels of the left image, with known truth, that the right camera sees, and those that a nearer
/// surface hides from it: 255, else 0.
struct Visibility {
  cv::Mat1b nonoccluded;
  cv::Mat1b occluded;
};

/// From the data set's mask, or by NonOccludedMask() and OccludedMask().
/// @throws ConfigError when its maps differ in size.
Visibility VisibilityOf(const scenes::GroundTruth& truth);

}  // namespace sprout::evaluate

#endif  // SPROUT_SERVICES_TOOLS_EVALUATE_VISIBILITY_H_
