#include "services/refine/stereo/point_surface.h"

#include <algorithm>
#include <limits>

#include "common/core/parallel.h"
#include "services/refine/stereo/stereo_rules.h"
#include "services/refine/surface/plane_sums.h"

namespace sprout::refine {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();
// Against squares of distances in px: keeps normal equations regular where points lie on a line.
constexpr double kRegular = 1e-3;

double Square(double x) { return x * x; }

// Directions of the quadrants.
struct Quadrant {
  int across, down;
};
constexpr Quadrant kQuadrants[] = {{1, 1}, {-1, 1}, {-1, -1}, {1, -1}};

// The disparity of the least-squares plane through points, at the origin.
double DisparityAtOrigin(const PlaneSums& sums) {
  const cv::Point2d p = sums.slopes.SlopeOf(sums.x, sums.y);
  return (sums.d - p.x * sums.slopes.xd - p.y * sums.slopes.yd) /
         (sums.n - p.x * sums.x - p.y * sums.y);
}

}  // namespace

// The sum of columns and rows: the nearest of a quadrant is then that of a cell beside or below.
double PointSurface::Distance(int index, cv::Point cell) const {
  if (index == kNone) return kInfinite;
  const cv::Point2d centre = grid_.CentrePx(cell);
  return std::abs(SeedOf(index).u - centre.x) + std::abs(SeedOf(index).v - centre.y);
}

void PointSurface::PutIntoCells() {
  own_.setTo(kNone);
  for (size_t i = 0; i < seeds_.size(); ++i) {
    const cv::Point cell = grid_.CellOf(seeds_[i].u, seeds_[i].v);
    if (!grid_.Has(cell)) continue;
    const auto index = static_cast<int>(i);
    if (Distance(index, cell) < Distance(own_(cell), cell)) own_(cell) = index;
  }
}

void PointSurface::FindNearest(size_t quadrant) {
  const auto [across, down] = kQuadrants[quadrant];
  cv::Mat1i& nearest = quadrant_[quadrant];
  own_.copyTo(nearest);
  for (int i = 0; i < own_.rows; ++i) {
    const int y = down > 0 ? own_.rows - 1 - i : i;
    for (int j = 0; j < own_.cols; ++j) {
      const cv::Point cell(across > 0 ? own_.cols - 1 - j : j, y);
      if (nearest(cell) != kNone) continue;
      const cv::Point beside = cell + cv::Point(across, 0);
      const cv::Point below = cell + cv::Point(0, down);
      const int one = grid_.Has(beside) ? nearest(beside) : kNone;
      const int other = grid_.Has(below) ? nearest(below) : kNone;
      nearest(cell) = Distance(one, cell) <= Distance(other, cell) ? one : other;
    }
  }
}

// Sectors that turn around the cell like the arms of a pinwheel, so that each other cell is in one.
PointSurface::Around PointSurface::AroundCell(cv::Point cell) const {
  const std::array<cv::Point, kSectors> steps = {cv::Point(1, 0), cv::Point(0, 1), cv::Point(-1, 0),
                                                 cv::Point(0, -1)};
  Around around;
  for (size_t i = 0; i < kSectors; ++i) {
    const cv::Point next = cell + steps[i];
    around[i] = grid_.Has(next) ? quadrant_[i](next) : kNone;
  }
  return around;
}

// Eq. (M2), by iteratively reweighted least squares.
cv::Point2d PointSurface::SlopeAt(const Seed& seed, const Around& around) const {
  cv::Point2d slope;
  for (const double wider : {StereoRules::kFirstScale, 1.0, 1.0}) {
    SlopeSums sums(kRegular);
    for (const int index : around) {
      if (index == kNone) continue;
      const double x = double{SeedOf(index).u} - seed.u;
      const double y = double{SeedOf(index).v} - seed.v;
      const double d = double{SeedOf(index).disparity()} - seed.disparity();
      const double scale_px = wider * std::max(StereoRules::kPlaneScalePx,
                                               StereoRules::kPlaneScalePerPx * std::hypot(x, y));
      const double residual_px = d - slope.x * x - slope.y * y;
      sums.Add(1 / (Square(1 + Square(residual_px / scale_px)) * (x * x + y * y)), x, y, d);
    }
    slope = sums.Slope();
  }
  return slope;
}

void PointSurface::FindSlopes(const cv::Mat1b& asked) {
  std::vector<uint8_t> wanted(seeds_.size(), asked.empty() ? 1 : 0);
  for (int y = 0; y < asked.rows; ++y) {
    for (int x = 0; x < asked.cols; ++x) {
      if (asked(y, x) == 0) continue;
      for (const int index : AroundCell({x, y})) {
        if (index != kNone) wanted[static_cast<size_t>(index)] = 1;
      }
    }
  }
  slopes_.assign(seeds_.size(), {});
  ForEachParallel(static_cast<size_t>(own_.rows), [&](size_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < own_.cols; ++x) {
      const auto own = static_cast<size_t>(own_(y, x));
      if (own_(y, x) == kNone || wanted[own] == 0) continue;
      slopes_[own] = SlopeAt(seeds_[own], AroundCell({x, y}));
    }
  });
}

void PointSurface::Set(std::span<const Seed> seeds, const CellGrid& grid, const cv::Mat1b& asked) {
  seeds_ = seeds;
  if (seeds.empty()) return;
  grid_ = grid;
  own_.create(grid.size);
  PutIntoCells();
  ForEachParallel(kSectors, [&](size_t i) { FindNearest(i); });
  FindSlopes(asked);
}

double PointSurface::OffPx(cv::Point cell, double disparity_px) const {
  if (seeds_.empty()) return kInfinite;
  const cv::Point2d centre = grid_.CentrePx(cell);
  double off_px = kInfinite;
  for (const int index : AroundCell(cell)) {
    if (index == kNone) continue;
    const Seed& seed = SeedOf(index);
    const cv::Point2d& slope = slopes_[static_cast<size_t>(index)];
    const double here =
        seed.disparity() + slope.x * (centre.x - seed.u) + slope.y * (centre.y - seed.v);
    off_px = std::min(off_px, std::abs(here - disparity_px));
  }
  return off_px;
}

// Eq. (M1).
double PointSurface::SigmaPx(cv::Point cell) const {
  if (seeds_.empty()) return kInfinite;
  if (own_(cell) != kNone) return SeedOf(own_(cell)).sigma_px;
  const cv::Point2d centre = grid_.CentrePx(cell);
  const Around around = AroundCell(cell);
  const auto for_each = [&](const auto& visit) {
    for (const int index : around) {
      if (index == kNone) continue;
      const cv::Point2d off(SeedOf(index).u - centre.x, SeedOf(index).v - centre.y);
      visit(index, off, 1 / (off.dot(off) + Square(grid_.spacing_px / 2)));
    }
  };
  int sectors = 0;
  double nearest_px2 = kInfinite;
  double weights = 0;
  double noise = 0;
  PlaneSums plane(kRegular);
  for_each([&](int index, const cv::Point2d& off, double weight) {
    ++sectors;
    nearest_px2 = std::min(nearest_px2, off.dot(off));
    weights += weight;
    noise += weight * Square(SeedOf(index).sigma_px);
    plane.Add(weight, off.x, off.y, SeedOf(index).disparity());
  });
  if (sectors == 0) return kInfinite;
  // The variance grows beyond the outermost points, see (M1).
  double variance = noise / weights + Square(StereoRules::kUnseenPerPx) * nearest_px2;
  const double beyond = Square(StereoRules::kBeyondPerPx) * nearest_px2;
  if (sectors < 3) return std::sqrt(variance + beyond);
  if (sectors == 3) variance += beyond / 4;
  const double disparity = DisparityAtOrigin(plane);
  double disagreement = 0;
  for_each([&](int index, const cv::Point2d& off, double weight) {
    const cv::Point2d& slope = slopes_[static_cast<size_t>(index)];
    const double here = SeedOf(index).disparity() - slope.x * off.x - slope.y * off.y;
    disagreement += weight * Square(here - disparity);
  });
  return std::sqrt(variance + disagreement / weights);
}

}  // namespace sprout::refine
