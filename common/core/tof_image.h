#pragma once

#include <opencv2/core.hpp>

namespace sprout {

/// Largest depth (m) of a return: far beyond any range camera or lidar, and below the numbers that
/// drivers write for "no return" (65535, 1e20, FLT_MAX).
inline constexpr float kMaxTofDepthM = 10'000;

/// Whether a depth is that of a return: 0 < depth ≤ kMaxTofDepthM; NaN is not.
inline bool IsReturn(float depth_m) { return depth_m > 0 && depth_m <= kMaxTofDepthM; }

/// One range image of the ToF camera; 0×0 when there is no camera, or it gave nothing.
struct TofImage {
  cv::Mat1f depth_m;    ///< z along the ToF camera's optical axis, m; no return: not IsReturn()
  cv::Mat1f amplitude;  ///< strength of the signal, sensor's unit; empty when there is none
};

}  // namespace sprout
