#include "services/depth/map_filter.h"

#include <cassert>
#include <cmath>
#include <cstdlib>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "services/depth/flying.h"
#include "services/depth/rays.h"

namespace sprout::depth {
namespace {

cv::Mat1b MaskOf(const std::vector<cv::Point>& region, cv::Size size) {
  std::vector<cv::Point> corners = region;
  if (corners.size() == 2) {
    corners = {region[0], {region[1].x, region[0].y}, region[1], {region[0].x, region[1].y}};
  }
  cv::Mat1b mask(size, uint8_t{0});
  cv::fillPoly(mask, std::vector{corners}, cv::Scalar(255));
  return mask;
}

// Each rule on one pixel, in the order of DepthCounts.
class PixelRules {
 public:
  PixelRules(const FilterRules& rules, const RectifiedPair& pair, const cv::Mat1b& inside,
             const cv::Mat& confidence, const cv::Mat1b& flying)
      : rules_(rules),
        depth_m_(pair),
        rays_(pair, rules.base_from_left),
        inside_(inside),
        confidence_(confidence),
        flying_(flying) {}

  /// The count of the first rule that leaves the pixel out; nothing when it stays.
  int32_t DepthCounts::*Broken(int u, int v, int16_t disparity) const {
    const double z = double{depth_m_(disparity)};
    if (z > 0 && z < rules_.min_m) return &DepthCounts::near;
    // z = 0: at infinity or beyond.
    if (rules_.max_m > 0 && (z > rules_.max_m || z == 0)) return &DepthCounts::far;
    if (!inside_.empty() && inside_(v, u) == 0) return &DepthCounts::outside;
    if (rules_.box && !IsInBox(u, v, z)) return &DepthCounts::outside;
    if (rules_.min_confidence > 0 && confidence_.at<uint8_t>(v, u) < rules_.min_confidence) {
      return &DepthCounts::unsure;
    }
    if (!flying_.empty() && flying_(v, u) != 0) return &DepthCounts::flying;
    return nullptr;
  }

 private:
  bool IsInBox(int u, int v, double z) const {
    return z > 0 && rules_.box->contains(rays_.origin + z * rays_.Direction(u, v));
  }

  const FilterRules& rules_;
  DepthOfCounts depth_m_;
  Rays rays_;
  const cv::Mat1b& inside_;
  const cv::Mat& confidence_;
  const cv::Mat1b& flying_;
};

// OpenCV's time grows with the square of the corners: 20,000 took 40 s.
constexpr int kMaxCorners = 1000;
constexpr int kMaxCornerPx = 32767;  // px; OpenCV draws with 16 bits before the point

std::vector<cv::Point> RegionOf(const DepthConfig& config) {
  const auto& numbers = config.region();
  for (const int number : numbers) {
    if (std::abs(number) <= kMaxCornerPx) continue;
    throw ConfigError("depth.region: " + std::to_string(number) + "; allowed: −" +
                      std::to_string(kMaxCornerPx) + " to " + std::to_string(kMaxCornerPx));
  }
  if (numbers.size() % 2 != 0 || numbers.size() == 2) {
    throw ConfigError("depth.region: " + std::to_string(numbers.size()) +
                      " numbers; allowed: column and row of 2 corners of a rectangle, of 3 and "
                      "more of a polygon, or nothing");
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

}  // namespace

MapFilter::MapFilter(FilterRules rules) : rules_(std::move(rules)) {}

bool MapFilter::IsOff() const {
  return rules_.min_m == 0 && rules_.max_m == 0 && rules_.region.empty() && !rules_.box &&
         rules_.min_confidence == 0 && !rules_.remove_flying;
}

void MapFilter::DrawRegion(cv::Size size) {
  if (rules_.region.empty() || inside_.size() == size) return;
  inside_ = MaskOf(rules_.region, size);
  is_outside_ = cv::countNonZero(inside_) == 0;
}

bool MapFilter::RegionIsOutside(cv::Size size) {
  DrawRegion(size);
  return is_outside_;
}

DisparityImage MapFilter::Apply(const DisparityImage& map, const RectifiedPair& pair,
                                const cv::Mat& confidence, DepthCounts& counts) {
  assert(map.size() == pair.size());
  assert(rules_.min_confidence == 0 || confidence.size() == map.size());
  DrawRegion(map.size());
  const cv::Mat1b flying = rules_.remove_flying ? FindFlying(map) : cv::Mat1b();
  const PixelRules rules(rules_, pair, inside_, confidence, flying);
  counts = {};
  DisparityImage kept(map.counts().clone());
  for (int v = 0; v < kept.height(); ++v) {
    int16_t* const row = kept.counts()[v];
    for (int u = 0; u < kept.width(); ++u) {
      if (row[u] == DisparityImage::kInvalid) continue;
      ++counts.pixels;
      int32_t DepthCounts::*const broken = rules.Broken(u, v, row[u]);
      if (broken == nullptr) continue;
      ++(counts.*broken);
      row[u] = DisparityImage::kInvalid;
    }
  }
  return kept;
}

void RequireOrder(const char* low_name, double low, const char* high_name, double high) {
  if (low < high) return;
  throw ConfigError("depth." + std::string(low_name) + " = " + std::to_string(low) + ", depth." +
                    high_name + " = " + std::to_string(high) +
                    ": allowed: the first below the second");
}

bool HasBox(const DepthConfig& config) {
  const Eigen::AlignedBox3d box = BoxOf(config.box());
  const Eigen::AlignedBox3d unlimited = BoxOf(BoxConfig());
  return box.min() != unlimited.min() || box.max() != unlimited.max();
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
  if (!HasBox(config)) return rules;
  if (!base_from_left) {
    throw ConfigError("depth.box: needs depth.rig, a rig file with base_from_left");
  }
  rules.box = BoxOf(config.box());
  return rules;
}

}  // namespace sprout::depth
