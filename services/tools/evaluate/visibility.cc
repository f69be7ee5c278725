#include "services/tools/evaluate/visibility.h"

#include <cmath>

#include "common/config/config_error.h"
#include "common/measure/score.h"

namespace sprout::evaluate {
namespace {

cv::Mat1b Required(Result<cv::Mat1b> mask) {
  if (!mask) throw ConfigError(mask.error().text);
  return *std::move(mask);
}

}  // namespace

Visibility VisibilityOf(const scenes::GroundTruth& truth) {
  if (truth.nonoccluded.empty()) {
    return {Required(NonOccludedMask(truth.left, truth.right)),
            Required(OccludedMask(truth.left, truth.right))};
  }
  // Known, but not seen by the right camera, although within its image.
  cv::Mat1b occluded(truth.left.size(), uchar{0});
  for (int v = 0; v < occluded.rows; ++v) {
    for (int u = 0; u < occluded.cols; ++u) {
      const bool in_right_image = std::round(u - double{truth.left(v, u)}) >= 0;  // NaN is not
      if (in_right_image && truth.nonoccluded(v, u) == 0) occluded(v, u) = 255;
    }
  }
  return {truth.nonoccluded, occluded};
}

}  // namespace sprout::evaluate
