#include <string>
#include <utility>

#include "common/core/checks.h"
#include "common/messages/convert.h"
#include "common/messages/pose_fields.h"

namespace sprout {
namespace {

// Whether the arrays of a message are as long as its counts, which CheckZoneCounts() allows.
Result<void> CheckArrays(const tof_zones_t& message) {
  const int64_t zones = int64_t{message.columns} * message.rows;
  const int64_t targets = zones * message.targets_per_zone;
  const auto has = [](const auto& values, int64_t count) { return std::ssize(values) == count; };
  Checks checks;
  checks
      .Require(message.zone_count == zones && has(message.left, zones) &&
                   has(message.right, zones) && has(message.top, zones) &&
                   has(message.bottom, zones),
               "zone_count", message.zone_count, "columns × rows = " + std::to_string(zones))
      .Require(message.target_count == targets && has(message.depth_m, targets) &&
                   has(message.sigma_m, targets) && has(message.status, targets),
               "target_count", message.target_count,
               "targets_per_zone × zone_count = " + std::to_string(targets));
  if (!checks.ok()) return checks.error();
  return {};
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
  TofZones zones{.columns = message.columns,
                 .rows = message.rows,
                 .targets_per_zone = message.targets_per_zone,
                 .mode = static_cast<ZoneMode>(message.mode),
                 .left_from_sensor = PoseOf(message.left_from_sensor_rotation,
                                            message.left_from_sensor_translation_m),
                 .views = {},
                 .targets = {}};
  return CheckZoneCounts(zones)
      .and_then([&] { return CheckArrays(message); })
      .and_then([&] {
        for (size_t i = 0; i < message.left.size(); ++i) {
          zones.views.push_back(
              {message.left[i], message.right[i], message.top[i], message.bottom[i]});
        }
        for (size_t i = 0; i < message.depth_m.size(); ++i) {
          const auto status = static_cast<TargetStatus>(message.status[i]);
          // What stands there means nothing; the same message always gives the same bytes.
          zones.targets.push_back(status == TargetStatus::kNone
                                      ? ZoneTarget()
                                      : ZoneTarget{message.depth_m[i], message.sigma_m[i], status});
        }
        return CheckZones(zones);
      })
      .transform([&] { return std::move(zones); });
}

}  // namespace sprout
