#include "common/core/tof_zones.h"

#include <cmath>
#include <string>

#include "common/core/check_lens.h"
#include "common/core/checks.h"
#include "common/core/tof_image.h"

namespace sprout {
namespace {

constexpr float kMaxTangent = 100;  // 89.4° off the axis

void CheckZone(const ZoneView& view, size_t index, Checks& checks) {
  const std::string zone = "zone " + std::to_string(index) + ": ";
  const auto check = [&](const char* low_field, float low, const char* high_field, float high) {
    checks
        .Require(low >= -kMaxTangent && low <= kMaxTangent, (zone + low_field).c_str(), low,
                 "-100 to 100")
        .Require(high > low && high <= kMaxTangent, (zone + high_field).c_str(), high,
                 std::string("above ") + low_field + ", up to 100");
  };
  check("left", view.left, "right", view.right);
  check("top", view.top, "bottom", view.bottom);
}

void CheckTarget(const ZoneTarget& target, size_t index, Checks& checks) {
  const int status = static_cast<int>(target.status);
  const std::string name = "target " + std::to_string(index) + ": ";
  checks.Require(status >= 0 && status <= static_cast<int>(TargetStatus::kDoubtful),
                 (name + "status").c_str(), status, "NONE (0), VALID (1) or DOUBTFUL (2)");
  if (target.status == TargetStatus::kNone) return;
  checks
      .Require(IsReturn(target.depth_m), (name + "depth_m").c_str(), target.depth_m,
               "above 0, up to 10000")
      .Require(target.sigma_m > 0 && std::isfinite(target.sigma_m), (name + "sigma_m").c_str(),
               target.sigma_m, "a finite number > 0");
}

}  // namespace

Result<void> CheckZoneCounts(const TofZones& zones) {
  const std::string side = "1 to " + std::to_string(kMaxZonesPerSide) + ", or 0 like the other";
  const auto is_side = [](int one, int other) {
    return one == 0 ? other == 0 : one > 0 && one <= kMaxZonesPerSide;
  };
  const int mode = static_cast<int>(zones.mode);
  Checks checks;
  checks.Require(is_side(zones.columns, zones.rows), "columns", zones.columns, side)
      .Require(is_side(zones.rows, zones.columns), "rows", zones.rows, side)
      .Require(zones.targets_per_zone >= 1 && zones.targets_per_zone <= kMaxTargetsPerZone,
               "targets_per_zone", zones.targets_per_zone,
               "1 to " + std::to_string(kMaxTargetsPerZone))
      .Require(zones.mode == ZoneMode::kMean || zones.mode == ZoneMode::kNearest, "mode", mode,
               "MEAN (0) or NEAREST (1)");
  if (!checks.ok()) return checks.error();
  return {};
}

Result<void> CheckZones(const TofZones& zones) {
  if (Result<void> counts = CheckZoneCounts(zones); !counts) return counts;
  const auto count = static_cast<size_t>(zones.columns) * static_cast<size_t>(zones.rows);
  const size_t targets = count * static_cast<size_t>(zones.targets_per_zone);
  Checks checks;
  checks
      .Require(zones.views.size() == count, "views", zones.views.size(),
               "columns × rows = " + std::to_string(count))
      .Require(zones.targets.size() == targets, "targets", zones.targets.size(),
               "targets_per_zone × columns × rows = " + std::to_string(targets));
  CheckPoseFields(checks, "left_from_sensor", zones.left_from_sensor);
  for (size_t i = 0; i < zones.views.size() && checks.ok(); ++i) {
    CheckZone(zones.views[i], i, checks);
  }
  for (size_t i = 0; i < zones.targets.size() && checks.ok(); ++i) {
    CheckTarget(zones.targets[i], i, checks);
  }
  if (!checks.ok()) return checks.error();
  return {};
}

}  // namespace sprout
