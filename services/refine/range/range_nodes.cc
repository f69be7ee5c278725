#include "services/refine/range/range_nodes.h"

#include <algorithm>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "common/core/parallel.h"
#include "common/core/quantile.h"
#include "common/core/window_sums.h"
#include "services/refine/surface/plane_sums.h"

namespace sprout::refine {
namespace {

constexpr float kNothing = -1e9F;  // nearer than no surface

// How much grey changes along the rows around a point.
float TextureAt(const cv::Mat1b& left, const Seed& seed) {
  constexpr int kReach = RangeRules::kWindowRadius;
  if (!IsInside(seed.u, seed.v, left.size(), kReach + 0.5)) return 0;
  const int u = static_cast<int>(seed.u + 0.5);
  const int v = static_cast<int>(seed.v + 0.5);
  int sum = 0;
  for (int y = v - 2; y <= v + 2; y += 2) {
    const uint8_t* row = left[y] + u;
    for (int x = -kReach; x < kReach; ++x) {
      const int rise = row[x + 1] - row[x];
      sum += rise * rise;
    }
  }
  return static_cast<float>(1 + sum);
}

// Whether hardly any grey level differs from its neighbour: compression leaves of a plain surface
// the borders of blocks, which lie on the same columns in both images, wherever the surface is.
bool IsBlank(const cv::Mat1b& image, cv::Point at) {
  constexpr int kReach = RangeRules::kWindowRadius;
  int same = 0;
  for (int v = at.y - kReach; v <= at.y + kReach; ++v) {
    const uint8_t* row = image[v];
    for (int u = at.x - kReach; u < at.x + kReach; ++u) same += row[u] == row[u + 1] ? 1 : 0;
  }
  constexpr int kPairs = (2 * kReach + 1) * 2 * kReach;
  return same > RangeRules::kBlankShare * kPairs;
}

// By how much squared steps of grey between two columns are larger on the border of JPEG's blocks
// of 8×8 px than elsewhere; 0 where no border stands out.
double BlockVariance(const cv::Mat1b& image) {
  constexpr size_t kBlock = 8;
  constexpr int kMaxStep = 4;  // larger ones are of the scene
  constexpr int kRowStep = 3;
  std::array<int64_t, kBlock> squares{};
  std::array<int64_t, kBlock> counts{};
  for (int v = 0; v < image.rows; v += kRowStep) {
    const uint8_t* row = image[v];
    for (int u = 0; u + 1 < image.cols; ++u) {
      const int step = std::min(std::abs(row[u + 1] - row[u]), kMaxStep);
      squares[static_cast<size_t>(u) % kBlock] += step * step;
      ++counts[static_cast<size_t>(u) % kBlock];
    }
  }
  double sum = 0;
  double most = 0;
  for (size_t k = 0; k < kBlock; ++k) {
    const double mean = static_cast<double>(squares[k]) / static_cast<double>(counts[k] + 1);
    sum += mean;
    most = std::max(most, mean);
  }
  const double others = (sum - most) / (kBlock - 1);
  return most > RangeRules::kBlockGain * others ? most - others : 0;
}

}  // namespace

float DistinctnessOf(const OffsetCosts& costs) {
  // The median is the greatest cost with at most half of all below it: no branch to be foreseen.
  float median = -std::numeric_limits<float>::infinity();
  float least = -median;
  for (const float cost : costs) {
    int less = 0;
    for (const float other : costs) less += other < cost ? 1 : 0;
    least = std::min(least, cost);
    median = std::max(median, less <= RangeRules::kLabels / 2 ? cost : median);
  }
  return std::clamp(median - least, 0.0F, 1.0F);
}

bool ShareSurface(const RangeNode& a, const RangeNode& b) {
  return IsOnSurface(a, b.at, b.disparity) || IsOnSurface(b, a.at, a.disparity);
}

// Costs of all nodes; those without any are left out.
void RangeNodes::Compare(const cv::Mat1b& left, const cv::Mat1b& right) {
  const double blocks = BlockVariance(left);
  std::vector<uint8_t> known(nodes_.size());
  ForEachParallel(nodes_.size(), [&](size_t i) {
    RangeNode& node = nodes_[i];
    const auto moments = MomentsOf(left, right, {node.at, node.disparity, node.slope});
    known[i] = moments.has_value() ? 1 : 0;
    if (!moments) return;
    node.moments = *moments;
    const cv::Point at(static_cast<int>(std::lround(node.at.x)),
                       static_cast<int>(std::lround(node.at.y)));
    node.noise = NoiseVariance<RangeRules::kWindowRadius - 1>(left, at);
    if (blocks > 0 && IsBlank(left, at)) known[i] = 0;
  });
  size_t kept = 0;
  for (size_t i = 0; i < nodes_.size(); ++i) {
    if (known[i] != 0) nodes_[kept++] = nodes_[i];
  }
  nodes_.resize(kept);
  noise_ = RangeRules::kMinNoise;
  if (nodes_.empty()) return;
  std::vector<float> variances;
  variances.reserve(nodes_.size());
  for (const RangeNode& node : nodes_) variances.push_back(static_cast<float>(node.noise));
  noise_ = std::max(noise_, double{Quantile(variances, RangeRules::kNoiseQuantile)});
  noise_ += RangeRules::kBlockNoise * blocks;
  ForEachParallel(nodes_.size(), [&](size_t i) { SetCosts(nodes_[i]); });
}

// A vote's tail begins at the same part of the likeness that the node's texture allows: with little
// texture windows that belong together are hardly alike, yet in many nodes it shows.
void RangeNodes::SetCosts(RangeNode& node) const {
  node.costs = CostsOf(node.moments, noise_);
  node.distinctness = DistinctnessOf(node.costs);
  const auto noise = static_cast<float>(RangeRules::kUnlikeVariance + noise_);
  const float signal = std::max(0.0F, node.moments.left_variance - noise);
  node.max_vote = 1 - (1 - RangeRules::kMaxCost) * signal / (signal + noise);
}

void RangeNodes::View::Set(const RectifiedPair& pair, const TofSurface& surface,
                           std::span<const ProjectedPoint> points, float Seed::*column) {
  wide = std::max(1.0, surface.column_px() / 2);
  high = std::max(1.0, surface.row_px() / 2);
  Renew(nearest,
        {static_cast<int>(pair.width / wide) + 1, static_cast<int>(pair.height / high) + 1});
  nearest = kNothing;
  // Half a spacing for the point, another for the window.
  constexpr int kReach = 2;
  for (const ProjectedPoint& point : points) {
    const double x = point.seed.*column / wide;
    const double y = point.seed.v / high;
    if (!IsInside(x, y, nearest.size(), kReach)) continue;
    float& cell = nearest(static_cast<int>(y), static_cast<int>(x));
    cell = std::max(cell, point.seed.disparity());
  }
  constexpr int kSide = 2 * kReach + 1;
  cv::dilate(nearest, nearest, cv::Mat1b::ones(kSide, kSide), {-1, -1}, 1, cv::BORDER_CONSTANT,
             kNothing);
}

bool RangeNodes::View::Hides(double u, double v, double disparity, double tolerance_px) const {
  const cv::Point cell(static_cast<int>(u / wide), static_cast<int>(v / high));
  return cv::Rect({}, nearest.size()).contains(cell) &&
         double{nearest(cell)} > disparity + tolerance_px;
}

// Takes a point for its cell if it has more texture than those before, and no surface hides it.
void RangeNodes::Offer(const RangeInput& input, const ProjectedPoint& point, size_t index) {
  const TofSurface& surface = input.surface;
  const cv::Point cell = surface.CellOf(point) / side_;
  const Seed& seed = point.seed;
  const float texture = TextureAt(input.left, seed);
  if (!(texture > texture_(cell))) return;
  // Planes of one surface differ by their noise, too.
  const double tolerance_px = RangeRules::kSurfacePx + RangeRules::kNoiseSigmas * input.noise_px;
  const TofSurface::Plane plane = surface.PlaneOf(point, tolerance_px);
  const double nearer_px = tolerance_px + 1.5 * (std::abs(plane.slope.x) * surface.column_px() +
                                                 std::abs(plane.slope.y) * surface.row_px());
  if (plane.has_nearer || left_.Hides(seed.u, seed.v, plane.disparity, nearer_px) ||
      right_.Hides(seed.u_right, seed.v, plane.disparity, nearer_px)) {
    return;
  }
  texture_(cell) = texture;
  index_(cell) = static_cast<int>(index);
  planes_[index] = plane;
}

void RangeNodes::Set(const RangeInput& input, std::span<const ProjectedPoint> points) {
  const RectifiedPair& pair = input.rig.pair;
  const TofSurface& surface = input.surface;
  RunBoth([&] { left_.Set(pair, surface, points, &Seed::u); },
          [&] { right_.Set(pair, surface, points, &Seed::u_right); });
  side_ = std::max(1, static_cast<int>(std::ceil(std::sqrt(static_cast<double>(points.size()) /
                                                           double{RangeRules::kMaxNodes}))));
  size_ = {surface.columns() / side_ + 1, surface.rows() / side_ + 1};
  Renew(index_, size_);
  Renew(texture_, size_);
  index_ = -1;
  texture_ = 0;
  planes_.resize(points.size());
  // Points come row by row, and no two rows of cells share any.
  ForEachParallel(static_cast<size_t>(size_.height), [&](size_t row) {
    const auto begin_of = [&](int y) {
      const auto is_above = [&](const ProjectedPoint& point) {
        return surface.CellOf(point).y / side_ < y;
      };
      return static_cast<size_t>(std::ranges::partition_point(points, is_above) - points.begin());
    };
    const int y = static_cast<int>(row);
    const size_t end = begin_of(y + 1);
    for (size_t i = begin_of(y); i < end; ++i) Offer(input, points[i], i);
  });
  nodes_.clear();
  for (int y = 0; y < size_.height; ++y) {
    for (int x = 0; x < size_.width; ++x) {
      if (index_(y, x) < 0) continue;
      const auto point = static_cast<size_t>(index_(y, x));
      const TofSurface::Plane& plane = planes_[point];
      nodes_.push_back({.cell = {x, y},
                        .at = {points[point].seed.u, points[point].seed.v},
                        .disparity = plane.disparity,
                        .slope = plane.slope,
                        .whole = !plane.has_farther,
                        .moments = {}});
    }
  }
  Compare(input.left, input.right);
  index_ = -1;
  for (size_t i = 0; i < nodes_.size(); ++i) index_(nodes_[i].cell) = static_cast<int>(i);
}

cv::Point2d RangeNodes::SlopeOf(size_t node, std::span<const double> offsets_px) const {
  SlopeSums sums(1);  // px²
  for (const uint32_t other : SurfaceAround(node)) {
    const cv::Point2d way = nodes_[other].at - nodes_[node].at;
    sums.Add(1, way.x, way.y, offsets_px[other] - offsets_px[node]);
  }
  return sums.Slope();
}

void RangeNodes::Move(const RangeInput& input, std::span<const double> offsets_px) {
  ForEachParallel(nodes_.size(), [&](size_t i) {
    RangeNode& node = nodes_[i];
    const SlantedPatch patch{node.at, node.disparity + offsets_px[i],
                             node.slope + SlopeOf(i, offsets_px)};
    // What leaves the images shows nothing.
    node.moments = MomentsOf(input.left, input.right, patch).value_or(OffsetMoments{});
    SetCosts(node);
  });
}

double RangeNodes::SigmasWorseThan(const RangeNodes& others) const {
  const auto cost_of = [](const RangeNode& node) {
    return std::min(RangeRules::kMaxCost, node.costs[RangeRules::kZeroLabel]);
  };
  double sum = 0, squares = 0;
  for (const RangeNode& node : nodes_) {
    const int at = others.At(node.cell.x, node.cell.y);
    if (at < 0) continue;
    const RangeNode& other = others.nodes_[static_cast<size_t>(at)];
    if (!node.whole || !other.whole) continue;
    const double more = double{cost_of(node)} - double{cost_of(other)};
    sum += more;
    squares += more * more;
  }
  return squares > 0 ? sum / std::sqrt(squares) : 0;
}

bool RangeNodes::AreOneSurface(size_t a, size_t b) const {
  const cv::Point way = nodes_[b].cell - nodes_[a].cell;
  if (std::abs(way.x) <= 1 && std::abs(way.y) <= 1) return (links_[a].bits & BitOf(way)) != 0;
  return ShareSurface(nodes_[a], nodes_[b]);
}

void RangeNodes::Link() {
  // Each pair is asked once.
  const cv::Point later[] = {{1, 0}, {-1, 1}, {0, 1}, {1, 1}};
  links_.assign(nodes_.size(), {.around = {}, .count = 0, .bits = BitOf({0, 0})});
  for (size_t i = 0; i < nodes_.size(); ++i) {
    const cv::Point cell = nodes_[i].cell;
    for (const cv::Point& way : later) {
      const int other = At(cell.x + way.x, cell.y + way.y);
      if (other < 0 || !ShareSurface(nodes_[i], nodes_[static_cast<size_t>(other)])) continue;
      links_[i].bits |= BitOf(way);
      links_[static_cast<size_t>(other)].bits |= BitOf(-way);
    }
    // What lies before it has been asked.
    Links& links = links_[i];
    for (int y = -1; y <= 1; ++y) {
      for (int x = -1; x <= 1; ++x) {
        if ((links.bits & BitOf({x, y})) == 0) continue;
        links.around[links.count++] = static_cast<uint32_t>(At(cell.x + x, cell.y + y));
      }
    }
  }
}

}  // namespace sprout::refine
