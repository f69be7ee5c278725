#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>

#include "common/core/rig.h"

namespace sprout {

/// A plane of space as a rectified pair sees it: its disparity is linear in the pixel,
///
///     d(u, v) = du · u + dv · v + d0   px
struct DisparityPlane {
  double du = 0;
  double dv = 0;
  double d0 = 0;

  double At(double u, double v) const { return du * u + dv * v + d0; }
};

/// The plane in the left rectified frame (m), its normal towards the scene: the offset is minus the
/// distance of the left camera's centre from it.
/// @returns nothing for one that passes through the camera or lies behind it. O(1).
std::optional<Eigen::Hyperplane<double, 3>> PlaneInSpace(const DisparityPlane& plane,
                                                         const RectifiedPair& pair);

/// A plane through a map of disparities, and the pixels that it is made of.
struct PlaneFit {
  DisparityPlane plane;
  double limit_px = 0;  ///< pixels farther than this from the plane are outliers
  int64_t inliers = 0;
  int64_t outliers = 0;
};

/// Fewest pixels with a disparity that a plane is fitted to: five for each of its numbers.
inline constexpr int64_t kMinPlanePixels = 15;

/// Fits a plane by least squares to the disparities that are no outliers. Outliers are found before
/// the fit, so they do not tilt it:
///
/// 1. The region is cut into 6 × 6 blocks. A block counts with the medians of its pixels' u, v and
///    d. Of all planes through three blocks the start is the one with the least median of |d −
///    plane| over the blocks (least median of squares, Rousseeuw 1984): up to nearly half of the
///    blocks may be anything.
/// 2. s = 1.4826 · median |d − plane|, the standard deviation of normal noise; beyond max(4 s,
///    1/16 px) a pixel is an outlier. Of normal noise that takes 6 of 100,000 pixels, and 0.05 % of
///    its RMS (3 s would take 1.3 %); rounding to counts makes 1/32 px.
/// 3. Least squares over the others; steps 2 and 3 until nothing changes, at most 10 times.
///
/// Disparity, not depth: there the noise of stereo is the same for near and far pixels, and the
/// plane is linear.
/// @param disparity_px  NaN or infinite = none.
/// @param corner        pixel of the left image that the map's first pixel is.
/// @returns nothing with fewer than kMinPlanePixels, or when they or their blocks lie on a line.
/// O(pixels).
std::optional<PlaneFit> FitPlane(const cv::Mat1f& disparity_px, cv::Point corner);

}  // namespace sprout
