#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/config/config.h"
#include "common/core/rig.h"
#include "common/core/tof_image.h"
#include "common/scenes/lens_view.h"
#include "common/scenes/tof_grid.h"

namespace sprout::scenes {

/// The camera's image, and its unambiguous range.
struct Sr4000Frame {
  TofImage tof;
  double unambiguous_range_m = 0;  ///< m along the ray; 0 = ranges are unambiguous
};

/// Simulation of a SwissRanger SR4000: a ToF camera of 176 × 144 pixels between the two colour
/// cameras, with its own lens, noise and errors. The source renders what the camera sees
/// (TofSamples); this class turns it into the camera's output.
///
/// Off unless config says so: distance error that depends on amplitude, multi-path, scattering in
/// the lens (StrayLightErrorM()), motion. WithRangeErrors() adds wiggling and other errors that
/// depend on the range. Not simulated: temperature, but as an offset of all ranges; light that
/// surfaces out of view send on; saturation.
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
  /// configuration, seed and frame only; same bytes on every machine. O(samples), but with
  /// multi-path.
  /// @param phase_images  what the camera saw while it took its four phase images, 90° apart; none
  /// = nothing moved.
  Sr4000Frame Measure(const TofSamples& samples, int64_t frame,
                      std::span<const TofSamples> phase_images = {}) const;

 private:
  double DepthM(const Footprint& footprint) const;
  // Errors that the scene makes: multi-path, scattering, motion; m along the ray.
  cv::Mat1d SceneErrorM(const std::vector<Footprint>& footprints,
                        std::span<const TofSamples> phase_images) const;
  void AddMotionErrorM(const std::vector<Footprint>& footprints,
                       std::span<const TofSamples> phase_images, cv::Mat1d& error_m) const;
  double AmplitudeErrorM(double amplitude) const;
  double TurnM() const;  // range whose phase is a whole turn
  double NoiseM(double amplitude) const;
  double AmbiguityM(const cv::Mat1f& depth_m) const;
  void Wrap(double ambiguity_m, cv::Mat1f& depth_m) const;

  Sr4000Config config_;
  uint32_t seed_;
  TofCamera calibrated_;
  TofCamera actual_;
  cv::Mat1d range_per_depth_;                // of each pixel: its ray's length at z = 1
  std::vector<Eigen::Vector3d> directions_;  // of each pixel, (x, y, 1)
};

}  // namespace sprout::scenes
