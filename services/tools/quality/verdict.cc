#include "services/tools/quality/verdict.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "common/app/version.h"
#include "common/config/config.h"
#include "common/config/config_error.h"
#include "common/core/image.h"
#include "common/core/joined.h"
#include "common/measure/edge_width.h"
#include "common/measure/target_limits.pb.h"

namespace sprout::quality {
namespace {

Limit LimitOf(const TargetLimit& message, const std::string& where) {
  Limit limit{.figure = FindTargetFigure(message.figure()), .at_least = {}, .at_most = {}};
  if (limit.figure == nullptr) {
    throw ConfigError(fmt::format("{}: no figure is called '{}'; allowed: {}", where,
                                  message.figure(),
                                  Joined(", ", TargetFigures(), &TargetFigure::name)));
  }
  if (message.has_at_least()) limit.at_least = message.at_least();
  if (message.has_at_most()) limit.at_most = message.at_most();
  const bool finite =
      std::isfinite(limit.at_least.value_or(0)) && std::isfinite(limit.at_most.value_or(0));
  const bool some = limit.at_least || limit.at_most;
  const bool ordered = !limit.at_least || !limit.at_most || *limit.at_least <= *limit.at_most;
  if (some && finite && ordered) return limit;
  throw ConfigError(
      fmt::format("{}: {}: allowed is at_least, at_most or both, finite numbers in this order",
                  where, limit.figure->name));
}

using Json = nlohmann::ordered_json;

const Limit* LimitFor(const TargetFigure& figure, std::span<const Limit> limits) {
  const auto found = std::ranges::find(limits, &figure, &Limit::figure);
  return found == limits.end() ? nullptr : &*found;
}

Json RectJson(const cv::Rect& rect) { return {rect.x, rect.y, rect.width, rect.height}; }

template <typename T>
Json OrNull(const std::optional<T>& value) {
  return value ? Json(*value) : Json(nullptr);
}

}  // namespace

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

bool Limit::IsKept(const TargetQuality& quality) const {
  const std::optional<double>& value = quality.*figure->value;
  return value && (!at_least || *value >= *at_least) && (!at_most || *value <= *at_most);
}

std::string Limit::Text() const {
  if (at_least && at_most) return fmt::format("{:g} to {:g}", *at_least, *at_most);
  return at_least ? fmt::format(">= {:g}", *at_least) : fmt::format("<= {:g}", *at_most);
}

std::vector<Limit> LoadLimits(const std::filesystem::path& path) {
  const std::string where = "--limits " + path.string();
  TargetLimits messages;
  ParseTextFile(path, "limits", "a file of limit { figure: \"...\" at_most: ... }", messages);
  std::vector<Limit> limits;
  std::set<const TargetFigure*> seen;
  for (const TargetLimit& message : messages.limit()) {
    limits.push_back(LimitOf(message, where));
    if (seen.insert(limits.back().figure).second) continue;
    throw ConfigError(
        fmt::format("{}: two limits of {}; allowed: one", where, limits.back().figure->name));
  }
  if (limits.empty()) throw ConfigError(where + ": no limit in it; allowed: at least one");
  return limits;
}

bool IsGood(const TargetQuality& quality, std::span<const Limit> limits) {
  return TargetComplaint(quality).empty() &&
         std::ranges::all_of(limits, [&](const Limit& limit) { return limit.IsKept(quality); });
}

std::string TableText(const Measurement& measurement, std::span<const Limit> limits) {
  const TargetMeter& meter = measurement.meter();
  const TargetQuality quality = meter.Quality();
  const cv::Rect& region = meter.region();
  std::string text =
      fmt::format("region {},{},{},{} of {} px, {} frames", region.x, region.y, region.width,
                  region.height, SizeText(meter.pair().size()), quality.frames);
  if (quality.without_plane > 0) text += fmt::format(", {} without a plane", quality.without_plane);
  text += "\n";
  for (const TargetFigure& figure : TargetFigures()) {
    const Limit* const limit = LimitFor(figure, limits);
    if (limit == nullptr && !(quality.*figure.value)) continue;
    const std::string value = TargetText(figure, quality);
    text += fmt::format("  {:<29} {:>14}", figure.title, value);
    if (limit != nullptr) {
      text +=
          fmt::format("   {} {}", limit->IsKept(quality) ? "good:" : "BAD: allowed", limit->Text());
    }
    text += "\n";
  }
  return text;
}

std::string JsonText(const Measurement& measurement, std::span<const Limit> limits,
                     const std::string& input) {
  const TargetMeter& meter = measurement.meter();
  const TargetQuality quality = meter.Quality();
  Json figures = Json::object();
  for (const TargetFigure& figure : TargetFigures()) {
    figures[std::string(figure.name)] = OrNull(quality.*figure.value);
  }
  Json kept = Json::array();
  for (const Limit& limit : limits) {
    kept.push_back({{"figure", limit.figure->name},
                    {"at_least", OrNull(limit.at_least)},
                    {"at_most", OrNull(limit.at_most)},
                    {"kept", limit.IsKept(quality)}});
  }
  const Json json = {{"version", Version()},
                     {"input", input},
                     {"size", {meter.pair().width, meter.pair().height}},
                     {"region", RectJson(meter.region())},
                     {"edge", meter.edge() ? RectJson(*meter.edge()) : Json(nullptr)},
                     {"true_distance_m", OrNull(measurement.settings().distance_m)},
                     {"frames", quality.frames},
                     {"frames_without_plane", quality.without_plane},
                     {"maps_of_another_size", measurement.other_size()},
                     {"maps_without_calibration", measurement.without_calibration()},
                     {"figures", std::move(figures)},
                     {"limits", std::move(kept)},
                     {"good", limits.empty() ? Json(nullptr) : Json(IsGood(quality, limits))}};
  // Paths may hold any bytes; JSON may not.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string MissingText(const TargetQuality& quality, const TargetSettings& settings) {
  std::string text;
  if (const std::string why = TargetComplaint(quality); quality.frames > 0 && !why.empty()) {
    text += why + "\n";
  }
  if (!settings.distance_m)
    text += "no Z-accuracy: the true distance is not known (--distance-m)\n";
  if (quality.frames < 2) text += "no temporal noise: it takes at least two frames\n";
  if (settings.edge && !quality.edge_width_px) {
    text += fmt::format("no edge width: no step of {:g} px or more in --edge\n", kMinEdgeStepPx);
  }
  if (quality.distance_m && !quality.sigma_claimed_px) {
    text +=
        "no sigma claimed: the maps come without a standard deviation (as logs with SPROUT_SIGMA "
        "have)\n";
  }
  return text;
}

}  // namespace sprout::quality
