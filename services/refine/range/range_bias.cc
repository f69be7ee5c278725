#include "services/refine/range/range_bias.h"

#include <algorithm>
#include <cmath>

#include "common/core/parallel.h"
#include "common/core/quantile.h"
#include "services/refine/range/surface_patches.h"

namespace sprout::refine {
namespace {

// Moves a point along its ray, so that its disparity grows.
void MovePoint(const RectifiedPair& pair, const Eigen::Vector3d& centre, double offset_px,
               ProjectedPoint& point) {
  const Eigen::Vector3d from = PointFromSeed(pair, point.seed);
  const double depth_m = pair.DepthFromDisparity(point.seed.disparity() + offset_px);
  const double scale = (depth_m - centre.z()) / (from.z() - centre.z());
  if (!(scale > 0 && depth_m > 0) || !std::isfinite(scale)) return;
  const Seed moved = ProjectToPair(pair, centre + scale * (from - centre));
  point.seed.u = moved.u;
  point.seed.v = moved.v;
  point.seed.u_right = moved.u_right;
}

}  // namespace

// Which nodes the images contradict; returns their share of those whose texture can show it.
double RangeBias::JudgeNodes() {
  const std::span<const RangeNode> nodes = nodes_.nodes();
  const std::span<const NodeOffset> offsets = field_.offsets();
  wrong_nodes_.assign(nodes.size(), 0);
  std::vector<float> variances;
  variances.reserve(nodes.size());
  for (const RangeNode& node : nodes) variances.push_back(static_cast<float>(node.noise));
  const double noise =
      double{RangeRules::kNoiseVariance} + double{Quantile(variances, RangeRules::kNoiseQuantile)};
  size_t judged = 0;
  size_t wrong = 0;
  for (size_t i = 0; i < nodes.size(); ++i) {
    const double signal = offsets[i].texture - noise;
    if (!nodes[i].whole || signal < RangeRules::kClearSignal * noise) continue;
    ++judged;
    // Eq. (R18).
    const double expected = signal / (signal + noise);
    if (offsets[i].likeness > RangeRules::kContradicted * expected) continue;
    ++wrong;
    wrong_nodes_[i] = 1;
  }
  KeepPatches(nodes_, RangeRules::kProvedNodes, wrong_nodes_);
  return judged < RangeRules::kFewestNodes
             ? 0
             : static_cast<double>(wrong) / static_cast<double>(judged);
}

// Whether any node moves, is unsure or is contradicted: with a sensor that is right none is.
bool RangeBias::SaysSomething() const {
  return field_.variance_px2() > 0 ||
         std::ranges::any_of(field_.offsets(),
                             [](const NodeOffset& offset) { return offset.offset_px != 0; }) ||
         std::ranges::any_of(wrong_nodes_, [](uint8_t wrong) { return wrong != 0; });
}

// What the nodes around a point say of it: those of its surface, within a widening window; if there
// are none, all.
RangeBias::PointError RangeBias::ErrorOf(const TofSurface& surface,
                                         const ProjectedPoint& point) const {
  struct Sums {
    double weight = 0, offset = 0, variance = 0, wrong = 0;
  };
  Sums own;
  Sums any;
  const double disparity = point.seed.disparity();
  const cv::Point2d at(point.seed.u, point.seed.v);
  const cv::Point2d cell = nodes_.CellOf(surface, point);
  const cv::Point nearest(static_cast<int>(std::lround(cell.x)),
                          static_cast<int>(std::lround(cell.y)));
  for (const int reach : {1, 2, 4, 8}) {
    for (int y = nearest.y - reach; y <= nearest.y + reach; ++y) {
      for (int x = nearest.x - reach; x <= nearest.x + reach; ++x) {
        const int index = nodes_.At(x, y);
        if (index < 0) continue;
        const auto node = static_cast<size_t>(index);
        const NodeOffset& offset = field_.offsets()[node];
        const double w = 1 / (0.25 + (cell.x - x) * (cell.x - x) + (cell.y - y) * (cell.y - y));
        const auto add = [&](Sums& sums) {
          sums.weight += w;
          sums.offset += w * offset.offset_px;
          sums.variance += w * offset.sigma_px * offset.sigma_px;
          sums.wrong += w * wrong_nodes_[node];
        };
        add(any);
        if (IsOnSurface(nodes_.nodes()[node], at, disparity)) add(own);
      }
    }
    if (own.weight > 0) break;
  }
  PointError error{.variance_px2 = field_.variance_px2()};
  const Sums& sums = own.weight > 0 ? own : any;
  if (sums.weight == 0) return error;
  error.offset_px = sums.offset / sums.weight;
  error.contradicted = sums.wrong > sums.weight / 2;
  if (own.weight > 0) error.variance_px2 = own.variance / own.weight;
  return error;
}

const RangeError& RangeBias::Apply(const RangeInput& input, const RangeSettings& settings,
                                   std::span<ProjectedPoint> points) {
  const RectifiedPair& pair = input.rig.pair;
  error_ = {};
  contradicted_.assign(points.size(), 0);
  nodes_.Set(input, points);
  const std::span<const RangeNode> nodes = nodes_.nodes();
  curve_.Estimate(nodes, pair,
                  input.coarse ? RangeRules::kSureSigmasCoarse : RangeRules::kSureSigmas);
  error_.curve.assign(curve_.knots().begin(), curve_.knots().end());
  // What the data sheet says is all that is known where the images show nothing.
  const auto data_sheet_px = [&](double disparity) {
    const double depth_m = pair.DepthFromDisparity(disparity);
    return pair.focal_px * pair.baseline_m / (depth_m * depth_m) * settings.error_m;
  };
  if (error_.curve.empty()) {
    for (ProjectedPoint& point : points) {
      point.seed.sigma_px = static_cast<float>(data_sheet_px(point.seed.disparity()));
    }
    return error_;
  }
  error_.curve_is_zero = curve_.is_zero();
  if (settings.field) {
    start_px_.clear();
    for (const RangeNode& node : nodes) start_px_.push_back(curve_.OffsetPx(pair, node.disparity));
    // Where points are far apart their slopes are not known well enough.
    field_.Estimate(nodes_, start_px_, !input.coarse);
    error_.contradicted_share = JudgeNodes();
    if (error_.contradicted_share > RangeRules::kRejectedShare) {
      error_.rejected = true;
      contradicted_.assign(points.size(), 1);
      return error_;
    }
  }
  const bool has_field = settings.field && SaysSomething();
  if (!has_field && curve_.is_zero()) {
    for (ProjectedPoint& point : points) point.seed.sigma_px = 0;
    return error_;
  }
  moved_.assign(points.size(), 0);
  const Eigen::Vector3d centre = input.rig.tof.left_from_tof_translation_m;
  ForEachParallel(points.size(), [&](size_t i) {
    ProjectedPoint& point = points[i];
    const double disparity = point.seed.disparity();
    const PointError error =
        has_field ? ErrorOf(input.surface, point) : PointError{.variance_px2 = 0};
    const double move_px = curve_.OffsetPx(pair, disparity) + error.offset_px;
    contradicted_[i] = error.contradicted ? 1 : 0;
    point.seed.sigma_px = static_cast<float>(
        std::hypot(std::sqrt(error.variance_px2),
                   std::min(curve_.SigmaPx(pair, disparity), data_sheet_px(disparity))));
    if (move_px == 0) return;
    moved_[i] = 1;
    MovePoint(pair, centre, move_px, point);
  });
  error_.moved_share = static_cast<double>(std::count(moved_.begin(), moved_.end(), 1)) /
                       static_cast<double>(std::max<size_t>(1, points.size()));
  return error_;
}

}  // namespace sprout::refine
