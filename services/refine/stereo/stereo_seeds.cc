#include "services/refine/stereo/stereo_seeds.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "common/core/image.h"
#include "common/core/parallel.h"
#include "services/refine/stereo/patch_matcher.h"
#include "services/refine/surface/plane_sums.h"

namespace sprout::refine {
namespace {

// A disc of cells.
cv::Mat1b Disc(double radius) {
  const int reach = static_cast<int>(radius);
  cv::Mat1b disc(2 * reach + 1, 2 * reach + 1, uint8_t{0});
  for (int y = -reach; y <= reach; ++y) {
    for (int x = -reach; x <= reach; ++x) {
      if (x * x + y * y <= radius * radius) disc(y + reach, x + reach) = 1;
    }
  }
  return disc;
}

struct Surface {
  double disparity = 0;
  double sigma = 0;
  cv::Point2d slope;  // px a px
};

// The surface at a pixel, from the means of pixels that lie opposite each other, so that its slant
// does not count. Nothing beside a depth edge, or where few disparities are known.
std::optional<Surface> SurfaceAt(const cv::Mat1f& map, int u, int v) {
  constexpr int kReach = StereoRules::kReach;
  if (u < kReach || v < kReach || u >= map.cols - kReach || v >= map.rows - kReach) return {};
  const float own = map(v, u);
  double sum = 0;
  double squares = 0;
  int pairs = 0;
  SlopeSums slopes(1);  // of pairs; those on one line say nothing of the direction across
  for (int y = 0; y <= kReach; ++y) {
    for (int x = y == 0 ? 0 : -kReach; x <= kReach; ++x) {
      const float one = map(v + y, u + x);
      const float opposite = map(v - y, u - x);
      if (std::abs(one - own) > StereoRules::kEdgePx ||
          std::abs(opposite - own) > StereoRules::kEdgePx)
        return {};
      const double off = (double{one} + opposite) / 2 - own;
      if (!(std::abs(off) <= StereoRules::kSurfacePx)) continue;  // or not known
      sum += off;
      squares += off * off;
      ++pairs;
      slopes.Add(1, x, y, (double{one} - opposite) / 2);
    }
  }
  if (pairs < StereoRules::kMinPairs) return {};
  return Surface{own + sum / pairs,
                 std::hypot(StereoRules::kSharedSigmaPx,
                            std::sqrt(squares / pairs * StereoRules::kSharing / pairs)),
                 slopes.Slope()};
}

}  // namespace

StereoSeedFinder::StereoSeedFinder(const RefineConfig& config) : config_(config) {
  RequireInRange(config, "refine");
}

double StereoSeedFinder::SpacingPx(int width) const {
  if (config_.stereo_spacing_px() > 0) return std::max(1.0, config_.stereo_spacing_px());
  return std::max(StereoRules::kMinSpacingPx, width / double{StereoRules::kColumns});
}

bool StereoSeedFinder::IsCoarse(double spacing_px, int width) const {
  return spacing_px > StereoRules::kCoarseCells * SpacingPx(width);
}

void StereoSeedFinder::FindUncovered(const CellGrid& grid, std::span<const Seed> seeds,
                                     std::span<const cv::Point2f> covered, double gap,
                                     double scale) {
  with_points_.create(grid.size);
  with_points_ = 0;
  for (const cv::Point2f& point : covered) {
    const cv::Point cell = grid.CellOf(point.x, point.y);
    if (grid.Has(cell)) with_points_(cell) = 1;
  }
  cv::dilate(with_points_, uncovered_, Disc(gap));
  uncovered_ = 1 - uncovered_;
  // Cells for which a match could hardly be surer than the points around are left out, too.
  points_.Set(seeds, grid, uncovered_);
  ForEachParallel(static_cast<size_t>(grid.size.height), [&](size_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < grid.size.width; ++x) {
      uint8_t& uncovered = uncovered_(y, x);
      if (uncovered != 0 && points_.SigmaPx({x, y}) <= StereoRules::kAskedSigmaPx * scale)
        uncovered = 0;
    }
  });
}

void StereoSeedFinder::MarkWanted(const CellGrid& grid, cv::Size size, int settle_cells) {
  const auto square = [](int reach) { return cv::Mat1b::ones(2 * reach + 1, 2 * reach + 1); };
  cv::Mat1b cells, large_gaps;
  cv::dilate(uncovered_, cells, square(StereoRules::kSmallGapCells));
  cv::erode(uncovered_, large_gaps, square(1));
  cv::dilate(large_gaps, large_gaps, square(1 + settle_cells));
  cells |= large_gaps;
  wanted_.create(size);
  std::vector<int> columns;
  columns.reserve(static_cast<size_t>(size.width));
  for (int u = 0; u < size.width; ++u) columns.push_back(grid.At(u));
  for (int v = 0; v < size.height; ++v) {
    if (v > 0 && grid.At(v) == grid.At(v - 1)) {
      std::copy_n(wanted_[v - 1], size.width, wanted_[v]);
      continue;
    }
    const uint8_t* row = cells[grid.At(v)];
    for (int u = 0; u < size.width; ++u) wanted_(v, u) = row[columns[static_cast<size_t>(u)]];
  }
}

// In every cell the pixel nearest to its centre that a seed can be taken from, unless the points
// around are surer of it.
void StereoSeedFinder::TakeFrom(const cv::Mat1b& left, const cv::Mat1b& right, const CellGrid& grid,
                                const cv::Mat1f& map, const cv::Mat1f& most_px, int row) {
  const double scale = matcher_.scale();
  const double cell = grid.spacing_px / scale;  // its side in pixels of the map
  std::vector<Seed>& seeds = found_[static_cast<size_t>(row)];
  seeds.clear();
  const auto pixels_of = [&](int index, int end) {
    return cv::Range(std::min(end, static_cast<int>(std::ceil(index * cell - 0.5))),
                     std::min(end, static_cast<int>(std::ceil((index + 1) * cell - 0.5))));
  };
  const auto middle_of = [&](int index, const cv::Range& pixels) {
    return std::max(pixels.start, static_cast<int>(std::ceil((index + 0.5) * cell - 1)));
  };
  const cv::Range rows = pixels_of(row, map.rows);
  const int middle_row = middle_of(row, rows);
  for (int column = 0; column < grid.size.width; ++column) {
    if (uncovered_(row, column) == 0) continue;
    const cv::Range columns = pixels_of(column, map.cols);
    double nearest = std::numeric_limits<double>::infinity();
    Seed best;
    SlantedPatch patch;
    const auto look_at = [&](int u, int v) {
      const double across = u + 0.5 - (column + 0.5) * cell;
      const double down = v + 0.5 - (row + 0.5) * cell;
      const double distance = across * across + down * down;
      if (std::isnan(map(v, u)) || distance >= nearest) return;
      const std::optional<Surface> surface = SurfaceAt(map, u, v);
      if (!surface) return;
      nearest = distance;
      patch.slope = surface->slope;
      best.u = static_cast<float>((u + 0.5) * scale - 0.5);
      best.v = static_cast<float>((v + 0.5) * scale - 0.5);
      best.u_right = best.u - static_cast<float>(surface->disparity * scale);
      best.origin = SeedOrigin::kStereo;
      best.sigma_px = static_cast<float>(std::hypot(surface->sigma * scale, column_error_px_));
    };
    // Mostly the pixel in the middle will do; then no other is nearer.
    const int middle = middle_of(column, columns);
    if (middle_row < rows.end && middle < columns.end) look_at(middle, middle_row);
    for (int v = rows.start; v < rows.end; ++v) {
      for (int u = columns.start; u < columns.end; ++u) look_at(u, v);
    }
    if (!std::isfinite(nearest) || best.sigma_px > points_.SigmaPx({column, row})) continue;
    if (scale > 1) {
      patch.at = {best.u, best.v};
      patch.disparity_px = best.disparity();
      // The match may be off by half a px of the matched image.
      const std::optional<double> finer = MatchPatch(left, right, patch, scale / 2);
      if (finer) best.u_right = best.u - static_cast<float>(*finer);
    }
    if (!most_px.empty() && best.disparity() > most_px(row, column)) continue;
    seeds.push_back(best);
  }
}

// @param width  of the images, with so many columns more than the cameras'.
StereoMatcherSettings StereoSeedFinder::SettingsFor(int width, int columns) const {
  const int most = config_.stereo_max_disparity_px();
  const int of_camera =
      most > 0 ? most
               : std::max((width - columns) / StereoRules::kWidthsPerDisparity + infinity_px_,
                          reach_px_);
  return {.max_disparity_px = std::clamp(of_camera + columns, 1, width),
          .most_pixels = config_.stereo_most_pixels()};
}

std::span<const Seed> StereoSeedFinder::FindCoarse(const cv::Mat1b& left, const cv::Mat1b& right,
                                                   double& error_px, int step) {
  StereoMatcherSettings settings = SettingsFor(left.cols, columns_);
  settings.most_pixels = std::min(settings.most_pixels, StereoRules::kFewPixels);
  settings.diagonal = false;
  wanted_.create(left.size());
  wanted_ = 1;
  const cv::Mat1f& map = matcher_.Match(left, right, wanted_, {}, settings);
  const double scale = matcher_.scale();
  error_px = scale / 2;
  const auto px = [&](int at) { return static_cast<float>((at + 0.5) * scale - 0.5); };
  seeds_.clear();
  for (int v = 0; v < map.rows; v += step) {
    for (int u = 0; u < map.cols; u += step) {
      if (std::isnan(map(v, u))) continue;
      seeds_.push_back({.u = px(u),
                        .v = px(v),
                        .u_right = px(u) - static_cast<float>(map(v, u) * scale),
                        .origin = SeedOrigin::kStereo});
    }
  }
  return seeds_;
}

double StereoSeedFinder::ShareBelowZero(const cv::Mat1b& left, const cv::Mat1b& right,
                                        int columns) {
  // Halved before they are widened: so no image of full size is copied.
  cv::Mat1b small_left = left;
  cv::Mat1b small_right = right;
  int scale = 1;
  const auto wider = [&] { return (columns + scale - 1) / scale; };
  while ((small_left.cols + wider()) * small_left.rows > StereoRules::kFewPixels) {
    small_left = Halved(small_left);
    small_right = Halved(small_right);
    scale *= 2;
  }
  const int zero = wider();
  cv::Mat1b wide_left, wide_right;
  cv::copyMakeBorder(small_left, wide_left, 0, 0, zero, 0, cv::BORDER_REPLICATE);
  cv::copyMakeBorder(small_right, wide_right, 0, 0, 0, zero, cv::BORDER_REPLICATE);
  const int most_px = SettingsFor(left.cols + columns, columns).max_disparity_px;
  wanted_.create(wide_left.size());
  wanted_ = 1;
  const cv::Mat1f& map = matcher_.Match(
      wide_left, wide_right, wanted_, {},
      {.max_disparity_px = most_px / scale + 1, .most_pixels = wide_left.size().area()});
  const int known = cv::countNonZero(map == map);
  const int below = cv::countNonZero(map < zero + 0.5);
  return known == 0 ? 0 : static_cast<double>(below) / known;
}

std::span<const Seed> StereoSeedFinder::Find(const cv::Mat1b& left, const cv::Mat1b& right,
                                             std::span<const Seed> seeds,
                                             std::span<const cv::Point2f> covered,
                                             double spacing_px, const cv::Mat1f& most_px) {
  constexpr int kWindowRadius = StereoRules::kWindowRadius;
  seeds_.clear();
  unanswered_ = 0;
  if (std::min(left.cols, left.rows) <= 2 * kWindowRadius) return seeds_;  // no window fits
  const CellGrid grid(SpacingPx(left.cols), left.size());
  const bool coarse = IsCoarse(spacing_px, left.cols);
  FindUncovered(grid, seeds, covered, coarse ? 0 : config_.stereo_gap(),
                MatchingScale(left.size(), config_.stereo_most_pixels()));
  if (cv::countNonZero(uncovered_) == 0) return seeds_;
  const bool between_points = coarse && !seeds.empty();  // that are believed
  MarkWanted(grid, left.size(),
             between_points ? StereoRules::kCoarseSettleCells : StereoRules::kSettleCells);
  StereoMatcherSettings settings = SettingsFor(left.cols, columns_);
  settings.diagonal = !between_points;
  const cv::Mat1f& map = matcher_.Match(left, right, wanted_, seeds, settings);
  found_.resize(static_cast<size_t>(grid.size.height));
  ForEachParallel(found_.size(), [&](size_t row) {
    TakeFrom(left, right, grid, map, most_px, static_cast<int>(row));
  });
  const cv::Rect2f inside(kWindowRadius, kWindowRadius,
                          static_cast<float>(left.cols - 2 * kWindowRadius),
                          static_cast<float>(left.rows - 2 * kWindowRadius));
  for (const std::vector<Seed>& row : found_) {
    std::copy_if(row.begin(), row.end(), std::back_inserter(seeds_), [&](const Seed& seed) {
      return seed.disparity() <= static_cast<float>(settings.max_disparity_px) &&
             inside.contains({seed.u, seed.v}) && inside.contains({seed.u_right, seed.v});
    });
  }
  unanswered_ = CountUnanswered(grid, spacing_px);
  return seeds_;
}

size_t StereoSeedFinder::CountUnanswered(const CellGrid& grid, double spacing_px) {
  for (const Seed& seed : seeds_) uncovered_(grid.CellOf(seed.u, seed.v)) = 0;
  cv::Mat1b near_points;
  cv::dilate(with_points_, near_points, Disc(1 + spacing_px / grid.spacing_px));
  uncovered_.setTo(0, near_points);
  return static_cast<size_t>(cv::countNonZero(uncovered_));
}

}  // namespace sprout::refine
