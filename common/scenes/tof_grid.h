#pragma once

#include <limits>
#include <opencv2/core.hpp>

#include "common/core/rig.h"
#include "common/core/tof_image.h"

namespace sprout::scenes {

/// A ToF camera at the left camera's position whose pixel (i, j) looks exactly through left pixel
/// (i·step + step/2, j·step + step/2), integer division: the paper's simulated sensor. Of size
/// floor(width / step) × floor(height / step), without lens distortion.
///
/// @param step_px  grid spacing in the left image, px.
/// @throws ConfigError when the grid would have no point: step_px < 1 or larger than the image.
TofCamera TofGridCamera(const RectifiedPair& pair, int step_px);

/// What the camera of TofGridCamera() measures: the depth of the true disparity at each grid
/// point, without noise; NaN where the disparity is unknown or its depth is not positive and
/// finite. The amplitude stays empty: it depends on the scene's infrared reflectance, which is
/// unknown.
///
/// @param left_disparity  px, of the size of the pair's images; NaN = unknown.
/// O(ToF pixels).
TofImage SampleTofGrid(const RectifiedPair& pair, int step_px, const cv::Mat1f& left_disparity);

/// What a ToF camera sees, finer than its pixels: kPerSide × kPerSide samples a ToF pixel.
struct TofSamples {
  static constexpr int kPerSide = 4;

  /// Nothing known anywhere.
  explicit TofSamples(cv::Size tof_size)
      : depth_m(tof_size * kPerSide, std::numeric_limits<float>::quiet_NaN()),
        albedo(tof_size * kPerSide, 0.f) {}

  /// Column (row) of the samples, fractional, at a position in the ToF image, px.
  static double SamplePosition(double tof_px) { return (tof_px + 0.5) * kPerSide - 0.5; }

  cv::Mat1f depth_m;  ///< z along the ToF axis, m; NaN = unknown
  cv::Mat1f albedo;   ///< 0 to 1; 0 where the depth is unknown
};

/// Simulated range sensors look at the middle of what both colour cameras see at this disparity, a
/// share of the image width: the middle of what stereo scenes have.
inline constexpr double kAimDisparityPerWidth = 0.08;

/// How far they are over the line between the colour cameras, half way between them, m.
inline constexpr double kAboveM = 0.02;

}  // namespace sprout::scenes
