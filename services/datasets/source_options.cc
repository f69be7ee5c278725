#include "services/datasets/source_options.h"

#include <algorithm>
#include <optional>
#include <string>

#include "common/core/number_text.h"

namespace sprout::datasets {

std::vector<SourceOption> SourceOptions(std::string_view text) {
  std::vector<SourceOption> options;
  while (true) {
    const size_t end = std::min(text.find('&'), text.size());
    const std::string_view option = text.substr(0, end);
    const size_t equals = std::min(option.find('='), option.size());
    options.push_back({.text = option,
                       .name = option.substr(0, equals),
                       .value = option.substr(std::min(equals + 1, option.size()))});
    if (end == text.size()) return options;
    text.remove_prefix(end + 1);
  }
}

SplitSourceText SplitSource(std::string_view source) {
  const size_t question = source.rfind('?');
  if (question == std::string_view::npos) return {std::string(source), {}};
  return {std::string(source.substr(0, question)), SourceOptions(source.substr(question + 1))};
}

bool ApplyZones(std::string_view tof, CaptureConfig& config) {
  if (!tof.starts_with(kZones)) return false;
  const std::string_view size = tof.substr(kZones.size());
  if (!size.empty()) {
    const size_t cross = size.find('x');
    const bool is_size = size.starts_with(':') && cross != std::string_view::npos;
    const auto columns = is_size ? ParseNumber<int>(size.substr(1, cross - 1)) : std::nullopt;
    const auto rows = is_size ? ParseNumber<int>(size.substr(cross + 1)) : std::nullopt;
    if (!columns || !rows) {
      throw ConfigError("capture.tof = " + std::string(tof) +
                        ": no size; allowed: zones:CxR such as zones:8x8");
    }
    config.mutable_zones()->set_columns(*columns);
    config.mutable_zones()->set_rows(*rows);
  }
  RequireInRange(config.zones(), "capture.zones");
  config.set_tof(std::string(kZones));
  return true;
}

bool ApplyZonesOption(const SourceOption& option, ZonesConfig& config) {
  if (option.name == "mode" && (option.value == "mean" || option.value == "nearest")) {
    config.set_mode(option.value == "mean" ? ZonesConfig::MEAN : ZonesConfig::NEAREST);
    return true;
  }
  const std::optional<int> targets = ParseNumber<int>(option.value);
  if (option.name == "targets" && targets) {
    config.set_targets(*targets);
    RequireInRange(config, "capture.zones");
    return true;
  }
  if (option.name != "mode" && option.name != "targets") return false;
  throw ConfigError("zones?" + std::string(option.text) +
                    ": no such value; allowed: " + std::string(kZonesOptions));
}

bool ApplySr4000Option(const SourceOption& option, Sr4000Config& config) {
  if (option.name != "blind" && option.name != "wrapped" && option.name != "calibration" &&
      option.name != "every") {
    return false;
  }
  const std::optional<double> number = ParseNumber<double>(option.value);
  if (!number) {
    throw ConfigError("sr4000?" + std::string(option.text) +
                      ": not a number; allowed: " + std::string(kSr4000Options));
  }
  if (option.name == "blind") config.set_blind_percent(*number);
  if (option.name == "wrapped") config.set_wrapped_percent(*number);
  if (option.name == "calibration") config.set_calibration_error_px(*number);
  if (option.name == "every") config.set_every_px(*number);
  RequireInRange(config, "capture.sr4000");
  return true;
}

}  // namespace sprout::datasets
