#include <cmath>
#include <string>

#include "common/core/checks.h"
#include "common/core/tof_image.h"
#include "common/messages/convert.h"
#include "common/messages/pose_fields.h"

namespace sprout {
namespace {

constexpr float kMostTangent = 100;  // 89.4° off the axis

Checks CheckZoneCounts(const tof_zones_t& message) {
  const int64_t zones = int64_t{message.columns} * message.rows;
  const int64_t targets = zones * message.targets_per_zone;
  const auto has = [](const auto& values, int64_t count) { return std::ssize(values) == count; };
  const std::string side = "1 to " + std::to_string(kMaxZonesPerSide) + ", or 0 like the other";
  const auto is_side = [](int32_t one, int32_t other) {
    return one == 0 ? other == 0 : one > 0 && one <= kMaxZonesPerSide;
  };
  Checks checks;
  checks.Require(is_side(message.columns, message.rows), "columns", message.columns, side)
      .Require(is_side(message.rows, message.columns), "rows", message.rows, side)
      .Require(message.targets_per_zone >= 1 && message.targets_per_zone <= kMaxTargetsPerZone,
               "targets_per_zone", message.targets_per_zone,
               "1 to " + std::to_string(kMaxTargetsPerZone))
      .Require(message.mode == tof_zones_t::MODE_MEAN || message.mode == tof_zones_t::MODE_NEAREST,
               "mode", message.mode, "MEAN (0) or NEAREST (1)")
      .Require(message.zone_count == zones && has(message.left, zones) &&
                   has(message.right, zones) && has(message.top, zones) &&
                   has(message.bottom, zones),
               "zone_count", message.zone_count, "columns × rows = " + std::to_string(zones))
      .Require(message.target_count == targets && has(message.depth_m, targets) &&
                   has(message.sigma_m, targets) && has(message.status, targets),
               "target_count", message.target_count,
               "targets_per_zone × zone_count = " + std::to_string(targets));
  return checks;
}

void CheckZone(const ZoneView& view, size_t index, Checks& checks) {
  const std::string zone = "zone " + std::to_string(index) + ": ";
  const auto check = [&](const char* low_field, float low, const char* high_field, float high) {
    checks
        .Require(low >= -kMostTangent && low <= kMostTangent, (zone + low_field).c_str(), low,
                 "-100 to 100")
        .Require(high > low && high <= kMostTangent, (zone + high_field).c_str(), high,
                 std::string("above ") + low_field + ", up to 100");
  };
  check("left", view.left, "right", view.right);
  check("top", view.top, "bottom", view.bottom);
}

void CheckTarget(const ZoneTarget& target, size_t index, Checks& checks) {
  const int status = static_cast<int>(target.status);
  const std::string name = "target " + std::to_string(index) + ": ";
  checks.Require(status >= 0 && status <= tof_zones_t::STATUS_DOUBTFUL, (name + "status").c_str(),
                 status, "NONE (0), VALID (1) or DOUBTFUL (2)");
  if (target.status == TargetStatus::kNone) return;
  checks
      .Require(IsReturn(target.depth_m), (name + "depth_m").c_str(), target.depth_m,
               "above 0, up to 10000")
      .Require(target.sigma_m > 0 && std::isfinite(target.sigma_m), (name + "sigma_m").c_str(),
               target.sigma_m, "a finite number > 0");
}

}  // namespace

tof_zones_t ToMessage(const FrameId& id, const TofZones& zones) {
  tof_zones_t message;
  message.header = ToMessage(id);
  message.columns = zones.columns;
  message.rows = zones.rows;
  message.zone_count = static_cast<int32_t>(zones.views.size());
  message.target_count = static_cast<int32_t>(zones.targets.size());
  message.targets_per_zone = zones.targets_per_zone;
  message.mode = static_cast<int32_t>(zones.mode);
  FillPose(zones.left_from_sensor, message.left_from_sensor_rotation,
           message.left_from_sensor_translation_m);
  for (const ZoneView& view : zones.views) {
    message.left.push_back(view.left);
    message.right.push_back(view.right);
    message.top.push_back(view.top);
    message.bottom.push_back(view.bottom);
  }
  for (const ZoneTarget& target : zones.targets) {
    message.depth_m.push_back(target.depth_m);
    message.sigma_m.push_back(target.sigma_m);
    message.status.push_back(static_cast<int8_t>(target.status));
  }
  return message;
}

Result<TofZones> FromMessage(const tof_zones_t& message) {
  Checks checks = CheckZoneCounts(message);
  if (!checks.ok()) return checks.error();
  TofZones zones{.columns = message.columns,
                 .rows = message.rows,
                 .targets_per_zone = message.targets_per_zone,
                 .mode = static_cast<ZoneMode>(message.mode),
                 .left_from_sensor = PoseOf(message.left_from_sensor_rotation,
                                            message.left_from_sensor_translation_m),
                 .views = {},
                 .targets = {}};
  CheckPoseFields(checks, "left_from_sensor", zones.left_from_sensor);
  for (size_t i = 0; i < message.left.size() && checks.ok(); ++i) {
    zones.views.push_back({message.left[i], message.right[i], message.top[i], message.bottom[i]});
    CheckZone(zones.views.back(), i, checks);
  }
  for (size_t i = 0; i < message.depth_m.size() && checks.ok(); ++i) {
    zones.targets.push_back(
        {message.depth_m[i], message.sigma_m[i], static_cast<TargetStatus>(message.status[i])});
    CheckTarget(zones.targets.back(), i, checks);
    // What stands there means nothing; the same message always gives the same bytes.
    if (zones.targets.back().status == TargetStatus::kNone) zones.targets.back() = {};
  }
  if (!checks.ok()) return checks.error();
  return zones;
}

}  // namespace sprout
