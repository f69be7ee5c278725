#include "services/depth/depth_options.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace sprout::depth {
namespace {

// OpenCV takes time with the square of the corners: of 20,000 it took 40 s.
constexpr int kMostCorners = 1000;
constexpr int kFarthestCorner = 32767;  // px; OpenCV draws with 16 bits before the point

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

void RequireOrder(const char* low_name, double low, const char* high_name, double high) {
  if (low < high) return;
  throw ConfigError("depth." + std::string(low_name) + " = " + std::to_string(low) + ", depth." +
                    high_name + " = " + std::to_string(high) +
                    ": allowed: the first below the second");
}

std::vector<cv::Point> RegionOf(const DepthConfig& config) {
  const auto& numbers = config.region();
  for (const int number : numbers) {
    if (std::abs(number) <= kFarthestCorner) continue;
    throw ConfigError("depth.region: " + std::to_string(number) + "; allowed: −" +
                      std::to_string(kFarthestCorner) + " to " + std::to_string(kFarthestCorner));
  }
  if (numbers.size() % 2 != 0 || numbers.size() == 2) {
    throw ConfigError(
        "depth.region: " + std::to_string(numbers.size()) +
        " numbers; allowed: column and row of 2 corners of a rectangle, of 3 and more "
        "of a polygon, or nothing");
  }
  if (numbers.size() > 2 * kMostCorners) {
    throw ConfigError("depth.region: " + std::to_string(numbers.size() / 2) +
                      " corners; allowed: up to " + std::to_string(kMostCorners));
  }
  std::vector<cv::Point> region;
  for (int i = 0; i < numbers.size(); i += 2) region.emplace_back(numbers[i], numbers[i + 1]);
  return region;
}

Eigen::AlignedBox3d BoxOf(const BoxConfig& box) {
  RequireOrder("box.min_x_m", box.min_x_m(), "box.max_x_m", box.max_x_m());
  RequireOrder("box.min_y_m", box.min_y_m(), "box.max_y_m", box.max_y_m());
  RequireOrder("box.min_z_m", box.min_z_m(), "box.max_z_m", box.max_z_m());
  return {Eigen::Vector3d(box.min_x_m(), box.min_y_m(), box.min_z_m()),
          Eigen::Vector3d(box.max_x_m(), box.max_y_m(), box.max_z_m())};
}

// Unlike a box that was not given, which has the defaults.
bool IsLimited(const BoxConfig& box) {
  const BoxConfig unlimited;
  const Eigen::AlignedBox3d one = BoxOf(box);
  const Eigen::AlignedBox3d all = BoxOf(unlimited);
  return one.min() != all.min() || one.max() != all.max();
}

FilterRules FilterOf(const DepthConfig& config, const std::optional<Pose>& base_from_left) {
  if (config.max_m() > 0) RequireOrder("min_m", config.min_m(), "max_m", config.max_m());
  if (config.min_confidence() > 0 && !config.confidence()) {
    throw ConfigError("depth.min_confidence = " + std::to_string(config.min_confidence()) +
                      ": needs depth.confidence: true; allowed without it: 0");
  }
  FilterRules rules{.min_m = config.min_m(),
                    .max_m = config.max_m(),
                    .region = RegionOf(config),
                    .box = std::nullopt,
                    .base_from_left = base_from_left.value_or(Pose()),
                    .min_confidence = config.min_confidence(),
                    .remove_flying = config.remove_flying()};
  if (!IsLimited(config.box())) return rules;
  if (!base_from_left) {
    throw ConfigError("depth.box: needs depth.rig, a rig file with base_from_left");
  }
  rules.box = BoxOf(config.box());
  return rules;
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
  // More than two compilers' rectifications of one file differ by.
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
