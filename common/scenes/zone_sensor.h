#pragma once

#include <cstdint>

#include "common/config/config.h"
#include "common/core/rig.h"
#include "common/core/tof_zones.h"
#include "common/scenes/tof_grid.h"

namespace sprout::scenes {

/// Simulation of a multi-zone ToF sensor such as ST's VL53L5CX: 8×8 or more zones, each of which
/// measures when the light of its whole field of view comes back. Between the two colour cameras,
/// with a field of view a little larger than the left image.
///
/// The light of a zone is split into targets at gaps in depth of at least config.separation_m().
/// Not simulated: light that leaks into neighbouring zones, cover glass, rounding to mm, motion.
class ZoneSensor {
 public:
  /// @param seed  of the random noise.
  /// @throws ConfigError when a value is out of range.
  ZoneSensor(const RectifiedPair& pair, const ZonesConfig& config, uint32_t seed);

  /// A camera that sees what the sensor sees, kPixelsPerZone a zone along either side.
  const TofCamera& camera() const { return camera_; }

  /// @param samples  what camera() sees.
  /// @returns the zones' targets. MEAN: the strongest first; NEAREST: the nearest first. A zone has
  /// none when more than half of its samples are unknown. Depends on samples, configuration, seed
  /// and frame only; same bytes on every machine. O(samples · log), one thread.
  TofZones Measure(const TofSamples& samples, int64_t frame) const;

 private:
  static constexpr int kPixelsPerZone = 4;

  ZonesConfig config_;
  uint32_t seed_;
  TofCamera camera_;
};

}  // namespace sprout::scenes
