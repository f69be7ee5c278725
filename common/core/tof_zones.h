#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/core/pose.h"
#include "common/core/result.h"

namespace sprout {

/// Most columns or rows of zones, and most targets of a zone.
inline constexpr int kMaxZonesPerSide = 64;
inline constexpr int kMaxTargetsPerZone = 4;

/// Which distance of a target a sensor reports; the numbers are those of lcmtypes/tof_zones_t.lcm.
enum class ZoneMode : int32_t {
  kMean = 0,     ///< mean of its depths, weighted by their light
  kNearest = 1,  ///< where its light begins
};

/// Numbers of lcmtypes/tof_zones_t.lcm.
enum class TargetStatus : int8_t {
  kNone = 0,      ///< no target
  kValid = 1,     ///< a target
  kDoubtful = 2,  ///< perhaps a target: little light
};

/// One of the surfaces in a zone.
struct ZoneTarget {
  float depth_m = 0;  ///< z along the sensor's axis, m; IsReturn() unless kNone
  /// Standard deviation, m, > 0 unless kNone. kMean: of the depths that the light comes from, with
  /// the sensor's noise; kNearest: of depth_m.
  float sigma_m = 0;
  TargetStatus status = TargetStatus::kNone;

  bool operator==(const ZoneTarget&) const = default;
};

/// Field of view of a zone in the sensor's frame: x / z and y / z at its sides.
struct ZoneView {
  float left = 0;
  float right = 0;  ///< > left
  float top = 0;
  float bottom = 0;  ///< > top

  bool operator==(const ZoneView&) const = default;
};

/// What a multi-zone range sensor measured; 0×0 zones when it gave nothing. Unlike a pixel of a
/// TofImage, a zone speaks of an area, not of a direction.
struct TofZones {
  int columns = 0;
  int rows = 0;
  int targets_per_zone = 1;
  ZoneMode mode = ZoneMode::kMean;
  Pose left_from_sensor;            ///< in the left rectified frame
  std::vector<ZoneView> views;      ///< columns × rows, row by row
  std::vector<ZoneTarget> targets;  ///< targets_per_zone of each zone

  /// The targets of a zone; `zone` is its index in `views`.
  std::span<const ZoneTarget> TargetsOf(size_t zone) const {
    const auto count = static_cast<size_t>(targets_per_zone);
    return std::span(targets).subspan(zone * count, count);
  }

  bool operator==(const TofZones&) const = default;
};

/// Whether counts, targets per zone and mode are possible, whatever `views` and `targets` hold.
/// @returns an error that names the field, its value, and what is allowed.
Result<void> CheckZoneCounts(const TofZones& zones);

/// Whether all is as documented above, views and targets included.
/// @returns an error as CheckZoneCounts(). O(zones).
Result<void> CheckZones(const TofZones& zones);

}  // namespace sprout
