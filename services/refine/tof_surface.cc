#include "services/refine/tof_surface.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "services/refine/window_difference.h"

namespace sprout {
namespace {

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

// The smaller of two steps by magnitude: beside an edge the one that stays on the surface. A step
// to a pixel without a point is NaN and does not count.
float GentlerStep(float a, float b) {
  if (std::isnan(a)) return std::isnan(b) ? 0 : b;
  if (std::isnan(b)) return a;
  return std::abs(a) <= std::abs(b) ? a : b;
}

// Points by square cells of an image.
class Cells {
 public:
  // @param positions  inside the image.
  // @param side       of a cell, px.
  Cells(const std::vector<cv::Point2d>& positions, cv::Size size, double side)
      : side_(side),
        wide_(static_cast<int>(size.width / side) + 1),
        high_(static_cast<int>(size.height / side) + 1),
        cells_(static_cast<size_t>(wide_) * static_cast<size_t>(high_)) {
    for (size_t i = 0; i < positions.size(); ++i) {
      cells_[CellIndex(Cell(positions[i].x), Cell(positions[i].y))].push_back(i);
    }
  }

  // Calls visit(index) for every point within a cell's side of a position, and some beyond.
  template <typename Visit>
  void ForNeighbours(const cv::Point2d& position, const Visit& visit) const {
    const int column = Cell(position.x);
    const int row = Cell(position.y);
    for (int y = std::max(row - 1, 0); y <= std::min(row + 1, high_ - 1); ++y) {
      for (int x = std::max(column - 1, 0); x <= std::min(column + 1, wide_ - 1); ++x) {
        for (size_t i : cells_[CellIndex(x, y)]) visit(i);
      }
    }
  }

 private:
  int Cell(double position) const { return static_cast<int>(position / side_); }
  size_t CellIndex(int x, int y) const {
    return static_cast<size_t>(y) * static_cast<size_t>(wide_) + static_cast<size_t>(x);
  }

  double side_;
  int wide_;
  int high_;
  std::vector<std::vector<size_t>> cells_;
};

constexpr double kSmallestCellPx = 5;

// How many times less the windows must differ at the piece's disparity than at the point's own.
constexpr double kClearlyBetter = 1.25;

}  // namespace

TofSurface::TofSurface(const Rig& rig, std::span<const ProjectedPoint> points)
    : size_(rig.pair.size()),
      column_px_(rig.pair.focal_px / rig.tof.fx),
      row_px_(rig.pair.focal_px / rig.tof.fy),
      disparity_(rig.tof.height, rig.tof.width, kNone) {
  for (const ProjectedPoint& point : points) {
    disparity_(point.tof_v, point.tof_u) = point.seed.disparity();
  }
}

float TofSurface::At(int tof_u, int tof_v) const {
  const bool inside =
      tof_u >= 0 && tof_v >= 0 && tof_u < disparity_.cols && tof_v < disparity_.rows;
  return inside ? disparity_(tof_v, tof_u) : kNone;
}

std::vector<bool> TofSurface::FindLoose(std::span<const ProjectedPoint> points,
                                        double tolerance_px) const {
  std::vector<bool> loose(points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    const ProjectedPoint& point = points[i];
    int support = -1;  // it supports itself
    for (int v = point.tof_v - 1; v <= point.tof_v + 1; ++v) {
      for (int u = point.tof_u - 1; u <= point.tof_u + 1; ++u) {
        if (std::abs(At(u, v) - point.seed.disparity()) <= tolerance_px) ++support;
      }
    }
    loose[i] = support < kSupport;
  }
  return loose;
}

TofSurface::Slant TofSurface::SlantAt(const ProjectedPoint& point) const {
  const int u = point.tof_u;
  const int v = point.tof_v;
  const float here = At(u, v);
  return {GentlerStep(At(u + 1, v) - here, here - At(u - 1, v)),
          GentlerStep(At(u, v + 1) - here, here - At(u, v - 1))};
}

std::vector<bool> TofSurface::FindHidden(std::span<const ProjectedPoint> points,
                                         const cv::Mat1b& left, const cv::Mat1b& right,
                                         const HiddenRule& rule) const {
  std::vector<Slant> slants;
  std::vector<cv::Point2d> in_left;
  std::vector<cv::Point2d> in_right;
  for (const ProjectedPoint& point : points) {
    slants.push_back(SlantAt(point));
    in_left.emplace_back(point.seed.u, point.seed.v);
    in_right.emplace_back(point.seed.u_right, point.seed.v);
  }
  const double cell_px = std::max(kSmallestCellPx, rule.reach * std::max(column_px_, row_px_));
  std::vector<bool> hidden(points.size());
  for (const std::vector<cv::Point2d>* image : {&in_left, &in_right}) {
    const std::vector<cv::Point2d>& positions = *image;
    const Cells cells(positions, size_, cell_px);
    for (size_t i = 0; i < points.size(); ++i) {
      const Seed& seed = points[i].seed;
      cells.ForNeighbours(positions[i], [&](size_t other) {
        // From the other point to this one, in ToF pixels.
        const double across = (positions[i].x - positions[other].x) / column_px_;
        const double down = (positions[i].y - positions[other].y) / row_px_;
        const double distance = std::max(std::abs(across), std::abs(down));
        if (hidden[i] || distance > rule.reach) return;
        const double piece_px = points[other].seed.disparity() + across * slants[other].across +
                                down * slants[other].down;
        if (piece_px <= seed.disparity() + rule.tolerance_px) return;
        // The piece at this pixel: what it would be in the other image.
        const double u = image == &in_left ? seed.u : seed.u_right + piece_px;
        const double u_right = image == &in_left ? seed.u - piece_px : seed.u_right;
        hidden[i] = distance <= rule.core ||
                    kClearlyBetter * WindowDifference(left, right, u, seed.v, u_right) <
                        WindowDifference(left, right, seed.u, seed.v, seed.u_right);
      });
    }
  }
  return hidden;
}

}  // namespace sprout
