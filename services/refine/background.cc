#include "services/refine/background.h"

#include <algorithm>
#include <cmath>

#include "common/core/parallel.h"

namespace sprout {
namespace {

constexpr float kRadius = BackgroundRule::kWindow / 2;

bool IsInWindow(const cv::Point2f& pixel, const cv::Point2f& centre) {
  return std::abs(pixel.x - centre.x) <= kRadius && std::abs(pixel.y - centre.y) <= kRadius;
}

bool IsBehind(float disparity, float nearest, double tolerance_px) {
  return disparity < nearest - tolerance_px;
}

// Whether any two seeds differ by enough.
bool CanAnyBeBehind(std::span<const Seed> seeds, double tolerance_px) {
  if (seeds.empty()) return false;
  const auto [least, most] = std::minmax_element(
      seeds.begin(), seeds.end(),
      [](const Seed& a, const Seed& b) { return a.disparity() < b.disparity(); });
  return IsBehind(least->disparity(), most->disparity(), tolerance_px);
}

}  // namespace

const std::vector<uint8_t>& BackgroundRule::Find(std::span<const Seed> seeds, cv::Size size,
                                                 double tolerance_px) {
  background_.assign(seeds.size(), 0);
  if (!CanAnyBeBehind(seeds, tolerance_px)) return background_;
  left_.pixels.clear();
  right_.pixels.clear();
  for (const Seed& seed : seeds) {
    const float row = std::round(seed.v);
    left_.pixels.emplace_back(std::round(seed.u), row);
    right_.pixels.emplace_back(std::round(seed.u_right), row);
  }
  RunBoth([&] { Mark(seeds, size, tolerance_px, left_); },
          [&] { Mark(seeds, size, tolerance_px, right_); });
  for (size_t i = 0; i < seeds.size(); ++i) {
    background_[i] = left_.background[i] | right_.background[i];
  }
  return background_;
}

void BackgroundRule::Mark(std::span<const Seed> seeds, cv::Size size, double tolerance_px,
                          View& view) {
  view.background.assign(seeds.size(), 0);
  view.cells.Fill(view.pixels, size, kWindow);
  for (size_t i = 0; i < seeds.size(); ++i) {
    const cv::Point2f& centre = view.pixels[i];
    float nearest = seeds[i].disparity();
    view.cells.ForNeighbours(centre, [&](size_t other) {
      if (!IsInWindow(view.pixels[other], centre)) return;
      nearest = std::max(nearest, seeds[other].disparity());
    });
    view.cells.ForNeighbours(centre, [&](size_t other) {
      if (!IsInWindow(view.pixels[other], centre)) return;
      if (IsBehind(seeds[other].disparity(), nearest, tolerance_px)) view.background[other] = 1;
    });
  }
}

}  // namespace sprout
