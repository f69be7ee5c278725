#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "common/core/number_text.h"
#include "common/scenes/dataset.h"
#include "common/scenes/kitti_source.h"
#include "common/scenes/middlebury_calibration.h"
#include "common/scenes/range_errors.h"
#include "common/scenes/source_options.h"
#include "common/scenes/synthetic_scene.h"

namespace sprout::scenes {
namespace {

std::unique_ptr<Dataset> OpenSyntheticText(std::string_view size_text,
                                           const CaptureConfig& config) {
  const std::string allowed = "synthetic:WxH with " + std::to_string(kMinSyntheticSide) + " to " +
                              std::to_string(kMaxSyntheticSide) + " px a side";
  const auto size = ParseSize(size_text);
  if (!size) throw BadSource(config.source(), "not a size", allowed);
  const auto [width, height] = *size;
  if (std::min(width, height) < kMinSyntheticSide || std::max(width, height) > kMaxSyntheticSide) {
    throw BadSource(config.source(), "size out of range", allowed);
  }
  return OpenSynthetic({width, height}, config);
}

// Applies what stands behind the '?' of a source.
void ApplyOptions(std::string_view kind, const std::vector<SourceOption>& options,
                  CaptureConfig& config) {
  for (const SourceOption& option : options) {
    if (kind == "kitti" && option.name == "beams") {
      config.set_beams(ParseNumber<int>(option.value).value_or(0));
    } else if (option.name == "tof") {
      if (!ApplyZones(option.value, config)) config.set_tof(std::string(option.value));
    } else if (!ApplyTofOption(option, /*is_scan=*/kind == "kitti", config)) {
      throw BadSource(config.source(), "no such option " + std::string(option.text),
                      kind == "kitti"
                          ? "?beams=64, 32, 16, 8 or 4, ?tof=none, " + std::string(kScanOptions)
                          : "?tof=grid, ?tof=none, ?tof=sr4000 with " +
                                std::string(kSr4000Options) + ", grid and sr4000 with " +
                                std::string(kRangeErrorOptions) + ", ?tof=zones:CxR with " +
                                std::string(kZonesOptions));
    }
  }
}

void RequireAllowed(const CaptureConfig& config) {
  if (config.tof() != "grid" && config.tof() != "sr4000" && config.tof() != kZones &&
      config.tof() != "none") {
    throw ConfigError("capture.tof = " + config.tof() +
                      ": no such ToF camera; allowed: grid, sr4000, zones:CxR, none");
  }
  constexpr std::array kBeams = {64, 32, 16, 8, 4};
  if (std::ranges::find(kBeams, config.beams()) == kBeams.end()) {
    throw ConfigError("capture.beams = " + std::to_string(config.beams()) +
                      ": not that many beams; allowed: 64, 32, 16, 8, 4");
  }
}

}  // namespace

std::unique_ptr<Dataset> OpenDataset(const CaptureConfig& original) {
  RequireInRange(original, "capture");
  CaptureConfig config = original;
  const auto [place, options] = SplitSource(original.source());
  const size_t colon = place.find(':');
  const std::string kind = place.substr(0, colon);
  const std::string argument = colon == std::string::npos ? "" : place.substr(colon + 1);
  ApplyZones(original.tof(), config);
  ApplyOptions(kind, options, config);
  RequireAllowed(config);
  const auto with_errors = [&](std::unique_ptr<Dataset> dataset) {
    return WithRangeErrors(std::move(dataset), config.range_errors(), config.seed());
  };
  if (kind == "middlebury") return with_errors(OpenMiddlebury(argument, config));
  if (kind == "kitti") return with_errors(OpenKitti(argument, config));
  if (kind == "synthetic") return with_errors(OpenSyntheticText(argument, config));
  const std::string allowed =
      "middlebury:DIR, kitti:DIR, kitti:DIR/ID, synthetic:WxH, and for sprout-capture log:FILE, "
      "genicam:RIG, opencv:LEFT,RIGHT, v4l2:DEVICE, ros2:left=TOPIC&right=TOPIC, "
      "mcap:FILE?left=TOPIC&right=TOPIC";
  throw BadSource(config.source(),
                  kind == "log" ? "only sprout-capture plays logs" : "no such source", allowed);
}

std::unique_ptr<Dataset> OpenDataset(const std::string& source) {
  CaptureConfig config;
  config.set_source(source);
  return OpenDataset(config);
}

}  // namespace sprout::scenes
