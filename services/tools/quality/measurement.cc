#include "services/tools/quality/measurement.h"

#include <fmt/core.h>

#include "common/config/config_error.h"

namespace sprout::quality {

void Measurement::Add(const MeasuredMap& map) {
  const std::string rig_id = RigId({.pair = map.pair, .tof = {}});
  if (!meter_) {
    Result<TargetMeter> meter = TargetMeter::For(settings_, map.pair, map.disparity_px.size());
    if (!meter) throw ConfigError(meter.error().text);
    meter_ = std::move(*meter);
    rig_id_ = rig_id;
  }
  const bool bad_sigma = !map.sigma.empty() && map.sigma.size() != map.disparity_px.size();
  if (rig_id != rig_id_ || map.disparity_px.size() != map.pair.size() || bad_sigma) {
    ++other_size_;
    return;
  }
  meter_->Add(map.disparity_px, map.sigma);
  newest_px_ = map.disparity_px;
}

std::string Measurement::LeftOutText() const {
  std::string text;
  const auto add = [&](int64_t count, const char* why) {
    if (count == 0) return;
    text += fmt::format("{}{} {}", text.empty() ? "left out: " : ", ", count, why);
  };
  add(other_size_, "maps of another size or calibration than the first");
  add(without_calibration_, "maps without a calibration");
  return text;
}

}  // namespace sprout::quality
