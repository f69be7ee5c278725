#include "services/refine/refiner.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>

#include "common/core/image.h"
#include "services/refine/tof_surface.h"

namespace sprout {
namespace {

constexpr int kRadius = Refiner::kWindow / 2;

int Pixel(float position) { return static_cast<int>(std::lround(position)); }

// Whether the window around a pixel lies in the image. Compares before it converts, since a point
// close to the camera plane projects to anywhere.
bool WindowFits(float u, float v, cv::Size size) {
  return u > kRadius - 0.5f && u < static_cast<float>(size.width - kRadius) - 0.5f &&
         v > kRadius - 0.5f && v < static_cast<float>(size.height - kRadius) - 0.5f;
}

// Seeds by the pixel they fall on in one image, to look up neighbourhoods.
class SeedGrid {
 public:
  // @param columns  column of each seed in this image, px.
  SeedGrid(std::span<const Seed> seeds, const std::vector<int>& columns, cv::Size size)
      : cells_wide_(size.width / Refiner::kWindow + 1),
        cells_high_(size.height / Refiner::kWindow + 1),
        cells_(static_cast<size_t>(cells_wide_) * static_cast<size_t>(cells_high_)) {
    for (size_t i = 0; i < seeds.size(); ++i) {
      const Entry entry{columns[i], Pixel(seeds[i].v), i};
      cells_[CellIndex(entry.u / Refiner::kWindow, entry.v / Refiner::kWindow)].push_back(entry);
    }
  }

  // Calls visit(index) for every seed in the window around a pixel, the centre included. A cell is
  // as wide as the window, so the window meets no cell beyond the eight around its own.
  template <typename Visit>
  void ForWindow(int u, int v, const Visit& visit) const {
    const int cell_u = u / Refiner::kWindow;
    const int cell_v = v / Refiner::kWindow;
    for (int y = std::max(cell_v - 1, 0); y <= std::min(cell_v + 1, cells_high_ - 1); ++y) {
      for (int x = std::max(cell_u - 1, 0); x <= std::min(cell_u + 1, cells_wide_ - 1); ++x) {
        for (const Entry& entry : cells_[CellIndex(x, y)]) {
          if (std::abs(entry.u - u) <= kRadius && std::abs(entry.v - v) <= kRadius) {
            visit(entry.index);
          }
        }
      }
    }
  }

 private:
  struct Entry {
    int u;
    int v;
    size_t index;
  };

  size_t CellIndex(int x, int y) const {
    return static_cast<size_t>(y) * static_cast<size_t>(cells_wide_) + static_cast<size_t>(x);
  }

  int cells_wide_;
  int cells_high_;
  std::vector<std::vector<Entry>> cells_;
};

// Marks the background in one of the images.
void MarkBackground(std::span<const Seed> seeds, const std::vector<int>& columns, cv::Size size,
                    double tolerance_px, std::vector<bool>& background) {
  const SeedGrid grid(seeds, columns, size);
  for (size_t i = 0; i < seeds.size(); ++i) {
    float nearest = seeds[i].disparity();
    grid.ForWindow(columns[i], Pixel(seeds[i].v),
                   [&](size_t other) { nearest = std::max(nearest, seeds[other].disparity()); });
    grid.ForWindow(columns[i], Pixel(seeds[i].v), [&](size_t other) {
      if (seeds[other].disparity() < nearest - tolerance_px) background[other] = true;
    });
  }
}

// Takes away the items that are flagged.
// @returns how many.
template <typename T>
int32_t Drop(const std::vector<bool>& flags, std::vector<T>& items) {
  size_t next = 0;
  for (size_t i = 0; i < items.size(); ++i) {
    if (!flags[i]) items[next++] = items[i];
  }
  const size_t dropped = items.size() - next;
  items.resize(next);
  return static_cast<int32_t>(dropped);
}

std::vector<Seed> SeedsOf(const std::vector<ProjectedPoint>& points) {
  std::vector<Seed> seeds;
  seeds.reserve(points.size());
  for (const ProjectedPoint& point : points) seeds.push_back(point.seed);
  return seeds;
}

}  // namespace

std::vector<bool> FindBackground(std::span<const Seed> seeds, cv::Size size, double tolerance_px) {
  std::vector<int> left_columns;
  std::vector<int> right_columns;
  for (const Seed& seed : seeds) {
    left_columns.push_back(Pixel(seed.u));
    right_columns.push_back(Pixel(seed.u_right));
  }
  std::vector<bool> background(seeds.size(), false);
  MarkBackground(seeds, left_columns, size, tolerance_px, background);
  MarkBackground(seeds, right_columns, size, tolerance_px, background);
  return background;
}

Refiner::Refiner(const RefineConfig& config) : config_(config) { RequireInRange(config, "refine"); }

Result<SeedSet> Refiner::Compute(const cv::Mat1b& left, const cv::Mat1b& right, const TofImage& tof,
                                 const TofProjector& projector) const {
  const Rig& rig = projector.rig();
  const cv::Size size = rig.pair.size();
  if (left.size() != size || right.size() != size) {
    return Fail("images of " + SizeText(left.size()) + " and " + SizeText(right.size()) +
                ": allowed is the calibrated size " + SizeText(size));
  }
  // Projection of every ToF point to (u, u', v) (paper, II-A).
  SeedSet result;
  const std::vector<ProjectedPoint> points = projector.Project(tof, result.outside);
  result.raw = static_cast<int32_t>(points.size()) + result.outside;

  std::vector<ProjectedPoint> kept = DropOutsideAndDark(left, tof, rig.pair, points, result);
  const TofSurface surface(rig, points);
  if (config_.loose_tolerance_px() > 0) {
    result.loose = Drop(surface.FindLoose(kept, config_.loose_tolerance_px()), kept);
  }

  // Rule 2 (paper, II-B): background that the ToF camera sees beside or behind a nearer surface.
  // What it drops still hides other points.
  const std::vector<bool> background =
      FindBackground(SeedsOf(kept), size, config_.background_tolerance_px());
  std::vector<bool> hidden(kept.size());
  if (config_.hidden_reach() > 0) {
    hidden = surface.FindHidden(kept, left, right,
                                {.core = config_.hidden_core(),
                                 .reach = config_.hidden_reach(),
                                 .tolerance_px = config_.hidden_tolerance_px()});
  }
  Drop(background, hidden);
  result.background = Drop(background, kept);
  result.hidden = Drop(hidden, kept);
  result.seeds = SeedsOf(kept);
  return result;
}

// Rule 1 (paper, II-B): unreliable depth on very dark regions.
std::vector<ProjectedPoint> Refiner::DropOutsideAndDark(const cv::Mat1b& left, const TofImage& tof,
                                                        const RectifiedPair& pair,
                                                        const std::vector<ProjectedPoint>& points,
                                                        SeedSet& counts) const {
  cv::Mat1f mean_grey;
  cv::boxFilter(left, mean_grey, CV_32F, {kWindow, kWindow});
  std::vector<ProjectedPoint> kept;
  for (const ProjectedPoint& point : points) {
    const Seed& seed = point.seed;
    if (!WindowFits(seed.u, seed.v, pair.size()) ||
        !WindowFits(seed.u_right, seed.v, pair.size()) || seed.disparity() < 0) {
      ++counts.outside;
    } else if (mean_grey(Pixel(seed.v), Pixel(seed.u)) < config_.min_mean_grey() ||
               (!tof.amplitude.empty() &&
                !(tof.amplitude(point.tof_v, point.tof_u) >= config_.min_amplitude()))) {
      ++counts.dark;
    } else {
      kept.push_back(point);
    }
  }
  return kept;
}

}  // namespace sprout
