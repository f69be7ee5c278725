#include "services/refine/surface/background.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "common/core/parallel.h"
#include "services/refine/surface/surface_rules.h"

namespace sprout::refine {
namespace {

bool IsInWindow(const cv::Point2f& pixel, const cv::Point2f& centre) {
  constexpr int kRadius = SurfaceRules::kRadius;
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

// The nearest seed in each pixel of a cell: the other seeds of a pixel are in the same windows, so
// nothing is behind them that is not behind it.
class NearestOfPixels {
 public:
  NearestOfPixels(std::span<const Seed> seeds, std::span<const cv::Point2f> pixels)
      : seeds_(seeds), pixels_(pixels) {}

  size_t operator()(std::span<uint32_t> cell) const {
    std::sort(cell.begin(), cell.end(), [&](uint32_t a, uint32_t b) {
      const auto key = [&](uint32_t i) {
        return std::tuple(pixels_[i].y, pixels_[i].x, -seeds_[i].disparity());
      };
      return key(a) < key(b);
    });
    const auto end = std::unique(cell.begin(), cell.end(),
                                 [&](uint32_t a, uint32_t b) { return pixels_[a] == pixels_[b]; });
    return static_cast<size_t>(end - cell.begin());
  }

 private:
  std::span<const Seed> seeds_;
  std::span<const cv::Point2f> pixels_;
};

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

// A seed is background when it lies behind the nearest one of a window that it is in.
void BackgroundRule::Mark(std::span<const Seed> seeds, cv::Size size, double tolerance_px,
                          View& view) {
  const NearestOfPixels nearest_of_pixels(seeds, view.pixels);
  constexpr int kWindow = SurfaceRules::kWindow;
  view.cells.Fill(view.pixels, size, kWindow, kWindow * kWindow, nearest_of_pixels);
  const auto nearest_around = [&](size_t i, const auto& disparity) {
    float nearest = seeds[i].disparity();
    view.cells.ForNeighbours(view.pixels[i], [&](size_t other) {
      if (!IsInWindow(view.pixels[other], view.pixels[i])) return;
      nearest = std::max(nearest, disparity(other));
    });
    return nearest;
  };
  view.nearest.resize(seeds.size());
  for (const uint32_t i : view.cells.points()) {
    view.nearest[i] = nearest_around(i, [&](size_t other) { return seeds[other].disparity(); });
  }
  view.background.resize(seeds.size());
  for (size_t i = 0; i < seeds.size(); ++i) {
    const float nearest = nearest_around(i, [&](size_t other) { return view.nearest[other]; });
    view.background[i] = IsBehind(seeds[i].disparity(), nearest, tolerance_px) ? 1 : 0;
  }
}

}  // namespace sprout::refine
