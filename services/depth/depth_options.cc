#include "services/depth/depth_options.h"

#include <algorithm>
#include <array>

#include "services/depth/filter_rules.h"

namespace sprout::depth {
namespace {

void RequireSomething(const DepthConfig& config) {
  if (config.publish_depth() || config.publish_cloud() || config.publish_preview() ||
      config.publish_sigma() || config.publish_scan() || !config.target().empty()) {
    return;
  }
  throw ConfigError(
      "depth.publish_depth, depth.publish_cloud, depth.publish_preview, depth.publish_sigma, "
      "depth.publish_scan = false, depth.target empty: nothing to publish; allowed: at least one "
      "of "
      "them");
}

void RequireSigma(const DepthConfig& config) {
  if (!config.publish_sigma() || config.input() != DepthConfig::FUSED) return;
  throw ConfigError(
      "depth.publish_sigma = true: fused maps have no standard deviation; allowed: false with "
      "input: FUSED");
}

std::string NamesOf(const RigPlaces& places) {
  std::string names;
  for (const auto& [name, place] : places.others) names += (names.empty() ? "" : ", ") + name;
  return names.empty() ? "none, the rig file has no others" : names;
}

View TargetOf(const std::string& target, const RigPlaces& places) {
  const auto found = places.others.find(target);
  if (found == places.others.end()) {
    throw ConfigError("depth.target = '" + target + "': allowed: " + NamesOf(places));
  }
  return ViewOf(found->second.lens, found->second.left_from_camera);
}

}  // namespace

DepthOptions OptionsOf(const DepthConfig& config) {
  RequireInRange(config, "depth");
  if (config.scale() == 3) throw ConfigError("depth.scale = 3: allowed: 1, 2, 4");
  RequireSomething(config);
  RequireSigma(config);
  RigPlaces places;
  if (!config.rig().empty()) places = PlacesOf(LoadRigFile(config.rig()), config.rig());
  if (config.rig().empty() && !config.target().empty()) {
    throw ConfigError("depth.target = '" + config.target() +
                      "': needs depth.rig, a rig file with others");
  }
  DepthOptions options{.filter = FilterOf(config, places.base_from_left),
                       .base_from_left = places.base_from_left,
                       .target = std::nullopt,
                       .scan = std::nullopt,
                       .pair = places.pair};
  if (!config.target().empty()) options.target = TargetOf(config.target(), places);
  if (config.publish_scan()) {
    RequireOrder("scan_min_height_m", config.scan_min_height_m(), "scan_max_height_m",
                 config.scan_max_height_m());
    options.scan = ScanBand{.min_height_m = config.scan_min_height_m(),
                            .max_height_m = config.scan_max_height_m(),
                            .step_deg = config.scan_step_deg()};
  }
  return options;
}

std::string RigComplaint(const DepthOptions& options, const RectifiedPair& pair) {
  // Larger than the difference between rectifications of one file by two compilers.
  constexpr double kTolerance = 1e-6;
  if (!options.pair) return "";
  const auto numbers = [](const RectifiedPair& p) {
    return std::array{double(p.width), double(p.height), p.focal_px, p.cx, p.cy,
                      p.cx_right,      p.baseline_m};
  };
  const auto expected = numbers(*options.pair);
  const auto found = numbers(pair);
  const bool same =
      std::equal(expected.begin(), expected.end(), found.begin(), [](double a, double b) {
        return std::abs(a - b) <= kTolerance * std::max(std::abs(a), std::abs(b));
      });
  return same
             ? ""
             : "RIG is not the calibration in depth.rig; allowed is the rig file that capture uses";
}

}  // namespace sprout::depth
