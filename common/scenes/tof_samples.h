#ifndef SPROUT_COMMON_SCENES_TOF_SAMPLES_H_
#define SPROUT_COMMON_SCENES_TOF_SAMPLES_H_

#include <limits>
#include <opencv2/core.hpp>

namespace sprout::scenes {

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

}  // namespace sprout::scenes

#endif  // SPROUT_COMMON_SCENES_TOF_SAMPLES_H_
