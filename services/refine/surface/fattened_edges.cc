#include "services/refine/surface/fattened_edges.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "services/refine/surface/surface_rules.h"

namespace sprout::refine {
namespace {

// A point before the farthest of the surfaces in the four cells around.
struct EdgePoint {
  size_t point;
  float beyond_px;  // disparity of that surface
};

std::vector<EdgePoint> FindEdge(const TofSurface& surface, const cv::Mat1f& disparities,
                                double step_px, const std::vector<ProjectedPoint>& points) {
  std::vector<EdgePoint> edge;
  const cv::Rect inner(1, 1, disparities.cols - 2, disparities.rows - 2);
  for (size_t i = 0; i < points.size(); ++i) {
    const cv::Point cell = surface.CellOf(points[i]);
    if (!inner.contains(cell)) continue;
    const float* const at = &disparities(cell);
    float farthest = *at;
    for (const int way : {-1, 1, -disparities.cols, disparities.cols}) {
      farthest = std::fmin(farthest, at[way]);  // of cells without a point it is NaN
    }
    if (*at - farthest > step_px) edge.push_back({.point = i, .beyond_px = farthest});
  }
  return edge;
}

// How much the images differ at a point by its own disparity and by that beyond the edge.
struct Differences {
  double own = 0, beyond = 0;

  bool PreferBeyond(double factor) const { return own > factor * beyond; }
  bool PreferOwn(double factor) const { return beyond > factor * own; }
};

Differences Compare(const cv::Mat1b& left, const cv::Mat1b& right, const Seed& seed,
                    double beyond_px) {
  const auto at = [&](double disparity) {
    return SurfaceRules::kNoise + WindowDifference(left, right, seed.u, seed.v, seed.u - disparity);
  };
  const Differences found{.own = at(seed.disparity()), .beyond = at(beyond_px)};
  return std::isfinite(found.own + found.beyond) ? found : Differences{};
}

}  // namespace

Fattening DropFattened(const TofSurface& surface, const cv::Mat1b& left, const cv::Mat1b& right,
                       double noise_px, std::vector<ProjectedPoint>& points,
                       std::vector<ProjectedPoint>& before) {
  const double step_px =
      std::max({SurfaceRules::kFattenedPx, SurfaceRules::kFattenedSteepest * surface.spacing_px(),
                SurfaceRules::kFattenedSigmas * noise_px});
  cv::Mat1f disparities(surface.rows(), surface.columns());
  for (int y = 0; y < surface.rows(); ++y) {
    for (int x = 0; x < surface.columns(); ++x) disparities(y, x) = surface.DisparityAt({x, y});
  }
  const auto compare = [&](const EdgePoint& of) {
    return Compare(left, right, points[of.point].seed, of.beyond_px);
  };
  const int most = std::max(SurfaceRules::kMaxFattened,
                            cvRound(SurfaceRules::kMaxFattenedPx / surface.spacing_px()));
  Fattening found;
  std::vector<uint8_t> dropped(points.size(), 0);
  for (; found.width < most; ++found.width) {
    const std::vector<EdgePoint> edge = FindEdge(surface, disparities, step_px, points);
    size_t wrong = 0, judged = 0;
    for (size_t i = 0; i < edge.size(); i += edge.size() / SurfaceRules::kEdgeSample + 1) {
      const Differences differences = compare(edge[i]);
      const bool is_wrong = differences.PreferBeyond(SurfaceRules::kClearlyBetter);
      wrong += is_wrong ? 1 : 0;
      judged += is_wrong || differences.PreferOwn(SurfaceRules::kClearlyBetter) ? 1 : 0;
    }
    const double allowed = SurfaceRules::kWrongEdges * static_cast<double>(judged);
    if (judged < SurfaceRules::kMinEdges || static_cast<double>(wrong) <= allowed) break;
    for (const EdgePoint& of : edge) {
      if (!compare(of).PreferBeyond(1)) continue;
      dropped[of.point] = 1;
      disparities(surface.CellOf(points[of.point])) = of.beyond_px;  // for the next pixels
    }
  }
  if (!found || found.width == most) return {};  // what does not end is no edge
  before.swap(points);
  points.clear();
  for (size_t i = 0; i < before.size(); ++i) {
    if (dropped[i] == 0) points.push_back(before[i]);
  }
  found.dropped_share = 1 - static_cast<double>(points.size()) / static_cast<double>(before.size());
  return found;
}

}  // namespace sprout::refine
