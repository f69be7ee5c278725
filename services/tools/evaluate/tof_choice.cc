#include "services/tools/evaluate/tof_choice.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "common/core/number_text.h"

namespace sprout::evaluate {
namespace {

constexpr std::string_view kAuto = "grid:auto";
constexpr std::string_view kGrid = "grid:";
constexpr std::string_view kSr4000 = "sr4000";
constexpr double kRowsPerSpacingPx = 111;  // 1110 rows: the paper's 10 px
constexpr double kMaxFactor = 100;
constexpr int kMaxSpacingPx = 1000;

ConfigError BadChoice(const std::string& text, const std::string& reason) {
  return ConfigError("--tof " + text + ": " + reason +
                     "; allowed: grid:auto, grid:auto*K (K above 0, at most 100), grid:N (N from "
                     "1 to 1000 px), sr4000 (with ?blind=P, &wrapped=P, &calibration=PX, "
                     "&every=K), all of them with " +
                     std::string(scenes::kRangeErrorOptions) +
                     "; zones:CxR (with ?mode=mean or nearest, &targets=N), none, and for kitti "
                     "scan, none");
}

}  // namespace

TofChoice::TofChoice(const std::string& text) : text_(text) {
  const std::string_view view = text_;
  const size_t question = std::min(view.find('?'), view.size());
  const std::string_view sensor = view.substr(0, question);
  if (view == kNone || view == kScan) return;
  if (sensor == kSr4000) {
    sr4000_.emplace();
  } else if (sensor.starts_with(scenes::kZones)) {
    CaptureConfig config;
    scenes::ApplyZones(sensor, config);
    zones_ = config.zones();
  } else {
    ReadSpacing(sensor);
  }
  if (question == view.size()) return;
  for (const scenes::SourceOption& option : scenes::SourceOptions(view.substr(question + 1))) {
    if (!ApplyOption(option)) throw BadChoice(text_, "no such option");
  }
}

void TofChoice::ReadSpacing(std::string_view grid) {
  if (grid == kAuto) return;
  if (grid.starts_with("grid:auto*")) {
    const std::optional<double> factor = ParseNumber<double>(grid.substr(kAuto.size() + 1));
    if (!factor || !(*factor > 0 && *factor <= kMaxFactor)) {
      throw BadChoice(text_, "no such factor");
    }
    factor_ = *factor;
  } else if (grid.starts_with(kGrid)) {
    spacing_px_ = ParseNumber<int>(grid.substr(kGrid.size()));
    if (!spacing_px_ || *spacing_px_ < 1 || *spacing_px_ > kMaxSpacingPx) {
      throw BadChoice(text_, "no such spacing");
    }
  } else {
    throw BadChoice(text_, "no such ToF camera");
  }
}

bool TofChoice::ApplyOption(const scenes::SourceOption& option) {
  if (zones_) return scenes::ApplyZonesOption(option, *zones_);
  if (sr4000_ && scenes::ApplySr4000Option(option, *sr4000_)) return true;
  return scenes::ApplyRangeErrorOption(option, false, range_errors_);
}

void TofChoice::Apply(int rows, CaptureConfig& config) const {
  config.mutable_range_errors()->MergeFrom(range_errors_);
  if (sr4000_) {
    config.set_tof(std::string(kSr4000));
    config.mutable_sr4000()->MergeFrom(*sr4000_);
    return;
  }
  if (zones_) {
    config.set_tof(std::string(scenes::kZones));
    config.mutable_zones()->MergeFrom(*zones_);
    return;
  }
  if (text_ == kNone) {
    config.set_tof(text_);
    return;
  }
  const double automatic_px = std::max(1.0, std::round(rows / kRowsPerSpacingPx));
  const int spacing_px = spacing_px_.value_or(
      std::clamp(static_cast<int>(std::lround(automatic_px * factor_)), 1, kMaxSpacingPx));
  config.set_tof("grid");
  config.set_tof_grid_px(spacing_px);
}

}  // namespace sprout::evaluate
