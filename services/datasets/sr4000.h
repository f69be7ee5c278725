#ifndef SPROUT_SERVICES_DATASETS_SR4000_H_
#define SPROUT_SERVICES_DATASETS_SR4000_H_

#include <cstdint>

#include "common/config/config.h"
#include "common/core/rig.h"
#include "common/core/tof_image.h"
#include "services/datasets/tof_samples.h"

namespace sprout::datasets {

/// The camera's image, and its unambiguous range.
struct Sr4000Frame {
  TofImage tof;
  double unambiguous_range_m = 0;  ///< m along the ray; 0 = ranges are unambiguous
};

/// Simulation of a SwissRanger SR4000: a ToF camera of 176 × 144 pixels between the two colour
/// cameras, with its own lens, noise and errors. The source renders what the camera sees
/// (TofSamples); this class turns it into the camera's output.
///
/// Not simulated: multi-path, scattering in the lens, motion, distance error that depends on
/// amplitude or temperature.
class Sr4000 {
 public:
  /// @param seed  of the random noise.
  /// @throws ConfigError when a value is out of range.
  Sr4000(const RectifiedPair& pair, const Sr4000Config& config, uint32_t seed);

  /// A camera with another pose or lens.
  /// @param camera  of 176 × 144 pixels; config's focal length and calibration error are ignored.
  Sr4000(const TofCamera& camera, const Sr4000Config& config, uint32_t seed);

  /// The camera according to the calibration.
  const TofCamera& calibrated() const { return calibrated_; }

  /// The camera as it really is, for rendering. Differs from calibrated() by
  /// config.calibration_error_px().
  const TofCamera& actual() const { return actual_; }

  /// Depth and amplitude (counts) of what the camera sees. A pixel has no return when less
  /// than half of its samples are known, they are mixed (config.mixed_percent()), its amplitude is
  /// below config.min_amplitude(), its surface is beyond config.max_range_m(), or it is among the
  /// config.blind_percent() of returns with the lowest amplitude; its amplitude is still given. A
  /// surface beyond the unambiguous range is measured modulo that range. Depends on samples,
  /// configuration, seed and frame only; same bytes on every machine. O(samples), one thread.
  Sr4000Frame Measure(const TofSamples& samples, int64_t frame) const;

 private:
  double NoiseM(double amplitude) const;
  double AmbiguityM(const cv::Mat1f& depth_m) const;
  void Wrap(double ambiguity_m, cv::Mat1f& depth_m) const;

  Sr4000Config config_;
  uint32_t seed_;
  TofCamera calibrated_;
  TofCamera actual_;
  cv::Mat1d range_per_depth_;  // of each pixel: its ray's length at z = 1
};

}  // namespace sprout::datasets

#endif  // SPROUT_SERVICES_DATASETS_SR4000_H_
