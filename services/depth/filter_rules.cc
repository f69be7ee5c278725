#include "services/depth/filter_rules.h"

#include <cmath>
#include <cstdlib>

namespace sprout::depth {
namespace {

// OpenCV takes time with the square of the corners: of 20,000 it took 40 s.
constexpr int kMaxCorners = 1000;
constexpr int kFarthestCorner = 32767;  // px; OpenCV draws with 16 bits before the point

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
  if (numbers.size() > 2 * kMaxCorners) {
    throw ConfigError("depth.region: " + std::to_string(numbers.size() / 2) +
                      " corners; allowed: up to " + std::to_string(kMaxCorners));
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

}  // namespace

void RequireOrder(const char* low_name, double low, const char* high_name, double high) {
  if (low < high) return;
  throw ConfigError("depth." + std::string(low_name) + " = " + std::to_string(low) + ", depth." +
                    high_name + " = " + std::to_string(high) +
                    ": allowed: the first below the second");
}

bool HasBox(const DepthConfig& config) { return IsLimited(config.box()); }

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
  if (!HasBox(config)) return rules;
  if (!base_from_left) {
    throw ConfigError("depth.box: needs depth.rig, a rig file with base_from_left");
  }
  rules.box = BoxOf(config.box());
  return rules;
}

}  // namespace sprout::depth
