#include "common/scenes/source_options.h"

#include <algorithm>
#include <array>
#include <optional>
#include <span>

#include "common/core/number_text.h"

namespace sprout::scenes {
namespace {

// An option whose value is a number.
template <typename Config>
struct NumberOption {
  std::string_view name;
  void (*set)(Config&, double);
};

// @returns whether the option is one of `known`.
template <typename Config>
bool ApplyNumber(const SourceOption& option, std::span<const NumberOption<Config>> known,
                 const std::string& prefix, const std::string& allowed, Config& config) {
  const auto found = std::ranges::find(known, option.name, &NumberOption<Config>::name);
  if (found == known.end()) return false;
  const std::optional<double> number = ParseNumber<double>(option.value);
  if (!number) {
    throw ConfigError(prefix + std::string(option.text) + ": not a number; allowed: " + allowed);
  }
  found->set(config, *number);
  return true;
}

// Each of these applies an option, and returns whether it is one that it knows.

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

bool ApplyRangeErrorOption(const SourceOption& option, bool is_scan, RangeErrorsConfig& config) {
  using C = RangeErrorsConfig;
  static constexpr std::array kOfScan = {
      NumberOption<C>{"bumps", [](C& c, double px) { c.set_bumps_px(px); }},
      NumberOption<C>{"unit", [](C& c, double factor) { c.set_unit(factor); }},
      NumberOption<C>{"range", [](C& c, double m) { c.set_offset_m(m); }},
      NumberOption<C>{"yaw", [](C& c, double degrees) { c.set_yaw_degrees(degrees); }},
      NumberOption<C>{"pitch", [](C& c, double degrees) { c.set_pitch_degrees(degrees); }}};
  static constexpr std::array kOfSimulation = {
      NumberOption<C>{"bumps", [](C& c, double px) { c.set_bumps_px(px); }},
      NumberOption<C>{"unit", [](C& c, double factor) { c.set_unit(factor); }},
      NumberOption<C>{"range", [](C& c, double mm) { c.set_offset_m(mm / 1000); }},
      NumberOption<C>{"wiggle", [](C& c, double mm) { c.set_wiggle_m(mm / 1000); }},
      NumberOption<C>{"period", [](C& c, double m) { c.set_wiggle_period_m(m); }}};
  if (option.text == "mirrored") {
    config.set_mirrored(true);
    return true;
  }
  const std::string allowed(is_scan ? kScanOptions : kRangeErrorOptions);
  if (!ApplyNumber<C>(option, is_scan ? kOfScan : kOfSimulation, "range error ", allowed, config)) {
    return false;
  }
  RequireInRange(config, "capture.range_errors");
  return true;
}

bool ApplySr4000Option(const SourceOption& option, Sr4000Config& config) {
  using C = Sr4000Config;
  static constexpr std::array kKnown = {
      NumberOption<C>{"blind", [](C& c, double percent) { c.set_blind_percent(percent); }},
      NumberOption<C>{"wrapped", [](C& c, double percent) { c.set_wrapped_percent(percent); }},
      NumberOption<C>{"calibration", [](C& c, double px) { c.set_calibration_error_px(px); }},
      NumberOption<C>{"every", [](C& c, double px) { c.set_every_px(px); }},
      NumberOption<C>{"amplitude", [](C& c, double mm) { c.set_amplitude_error_m(mm / 1000); }},
      NumberOption<C>{"multipath", [](C& c, double share) { c.set_multipath(share); }},
      NumberOption<C>{"scatter", [](C& c, double share) { c.set_scatter(share); }},
      NumberOption<C>{"motion", [](C& c, double share) { c.set_motion(share); }}};
  if (!ApplyNumber<C>(option, kKnown, "sr4000?", std::string(kSr4000Options), config)) return false;
  RequireInRange(config, "capture.sr4000");
  return true;
}

}  // namespace

ConfigError BadSource(const std::string& source, const std::string& reason,
                      const std::string& allowed) {
  return ConfigError("capture.source = " + source + ": " + reason + "; allowed: " + allowed);
}

std::vector<SourceOption> SourceOptions(std::string_view text) {
  std::vector<SourceOption> options;
  for (const std::string_view option : SplitAt('&', text)) {
    const size_t equals = std::min(option.find('='), option.size());
    const std::string_view name = option.substr(0, equals);
    if (const auto before = std::ranges::find(options, name, &SourceOption::name);
        before != options.end()) {
      throw ConfigError("capture.source: " + std::string(before->text) + " and " +
                        std::string(option) + ": allowed is each option once");
    }
    options.push_back({.text = option,
                       .name = name,
                       .value = option.substr(std::min(equals + 1, option.size()))});
  }
  return options;
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
    const auto zones = size.starts_with(':') ? ParseSize(size.substr(1)) : std::nullopt;
    if (!zones) {
      throw ConfigError("capture.tof = " + std::string(tof) +
                        ": no size; allowed: zones:CxR such as zones:8x8");
    }
    config.mutable_zones()->set_columns(zones->first);
    config.mutable_zones()->set_rows(zones->second);
  }
  RequireInRange(config.zones(), "capture.zones");
  config.set_tof(std::string(kZones));
  return true;
}

bool ApplyTofOption(const SourceOption& option, bool is_scan, CaptureConfig& config) {
  if (config.tof() == kZones) return ApplyZonesOption(option, *config.mutable_zones());
  if (config.tof() == "sr4000" && ApplySr4000Option(option, *config.mutable_sr4000())) return true;
  return config.tof() != "none" &&
         ApplyRangeErrorOption(option, is_scan, *config.mutable_range_errors());
}

}  // namespace sprout::scenes
