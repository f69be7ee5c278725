#include "services/refine/surface/smoothed_edges.h"

#include <algorithm>
#include <cmath>

#include "common/core/quantile.h"
#include "services/refine/surface/surface_rules.h"

namespace sprout::refine {
namespace {

// Adds the widths of the edges along a line of cells.
void AddWidths(const TofSurface& surface, cv::Point cell, const cv::Point& way, int length,
               std::vector<double>& widths) {
  const double edge_px = SurfaceRules::EdgePx(surface.spacing_px());
  double height_px = 0;  // of the steps of one sign so far
  double highest_px = 0;
  const auto end_edge = [&] {
    if (std::abs(height_px) >= SurfaceRules::kEdgeSteps * edge_px) {
      widths.push_back(std::abs(height_px) / highest_px);
    }
    height_px = highest_px = 0;
  };
  double last_px = surface.DisparityAt(cell);
  for (int i = 1; i < length; ++i) {
    cell += way;
    const double next_px = surface.DisparityAt(cell);
    const double step_px = next_px - last_px;
    last_px = next_px;
    const bool is_step = std::abs(step_px) > edge_px;
    if (!is_step || step_px * height_px < 0) end_edge();
    if (!is_step) continue;
    height_px += step_px;
    highest_px = std::max(highest_px, std::abs(step_px));
  }
  end_edge();
}

// The width that a quarter of the edges stay below. Slants are left out of them.
double SharpestOf(std::vector<double>& widths) {
  std::erase_if(widths, [](double width) { return width > SurfaceRules::kMaxEdgeWidth; });
  return widths.size() < SurfaceRules::kMinEdges ? 1
                                                 : Quantile(widths, SurfaceRules::kSharpestEdges);
}

// Along columns alone slanted floors look like edges; along rows a pixel that sees both surfaces
// makes two steps of one, at an upright edge in all of them.
double EdgeWidth(const TofSurface& surface) {
  std::vector<double> widths;
  for (int y = 0; y < surface.rows(); ++y) {
    AddWidths(surface, {0, y}, {1, 0}, surface.columns(), widths);
  }
  const double along_rows = SharpestOf(widths);
  for (int x = 0; x < surface.columns(); ++x) {
    AddWidths(surface, {x, 0}, {0, 1}, surface.rows(), widths);
  }
  return along_rows > SurfaceRules::kMixedWidth ? along_rows : SharpestOf(widths);
}

bool IsBesideEdge(const TofSurface& surface, const ProjectedPoint& point, int reach) {
  const cv::Rect cells(0, 0, surface.columns(), surface.rows());
  const cv::Point cell = surface.CellOf(point);
  const TofSurface::Plane plane =
      surface.PlaneOf(point, SurfaceRules::EdgePx(surface.spacing_px()));
  const cv::Point2d slope(plane.slope.x * surface.column_px(), plane.slope.y * surface.row_px());
  for (int y = -1; y <= 1; ++y) {
    for (int x = -1; x <= 1; ++x) {
      for (int i = 1; i <= reach; ++i) {
        const cv::Point way = i * cv::Point(x, y);
        if (!cells.contains(cell + way)) break;
        const double off_px =
            surface.DisparityAt(cell + way) - plane.disparity - slope.dot(cv::Point2d(way));
        if (std::abs(off_px) > SurfaceRules::kSmoothedPx) return true;
      }
    }
  }
  return false;
}

}  // namespace

Smoothing DropSmoothed(const TofSurface& surface, std::vector<ProjectedPoint>& points) {
  const double width = EdgeWidth(surface);
  if (width < SurfaceRules::kSmoothedWidth) return {};
  const auto all = static_cast<double>(points.size());
  const int reach = static_cast<int>(std::lround(width));
  const size_t dropped = std::erase_if(
      points, [&](const ProjectedPoint& point) { return IsBesideEdge(surface, point, reach); });
  return {.edge_width = width, .dropped_share = static_cast<double>(dropped) / all};
}

}  // namespace sprout::refine
