#ifndef SPROUT_COMMON_CORE_TOF_IMAGE_H_
#define SPROUT_COMMON_CORE_TOF_IMAGE_H_

#include <opencv2/core.hpp>

namespace sprout {

/// One range image of the ToF camera.
struct TofImage {
  cv::Mat1f depth_m;    ///< z along the ToF camera's optical axis, m; NaN = no return
  cv::Mat1f amplitude;  ///< strength of the signal, sensor's unit; empty when there is none
};

}  // namespace sprout

#endif  // SPROUT_COMMON_CORE_TOF_IMAGE_H_
