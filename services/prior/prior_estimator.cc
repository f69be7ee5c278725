#include "services/prior/prior_estimator.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "common/core/image.h"
#include "common/core/median.h"
#include "common/core/parallel.h"
#include "common/geometry/widened_frame.h"
#include "services/prior/edges/edge_surfaces.h"
#include "services/prior/edges/seed_planes.h"
#include "services/prior/triangulation/interpolation.h"

namespace sprout::prior {
namespace {

// The third corner of the triangle that lies inside of a side of the outline: the neighbours of a
// seed are in the order of the outline.
int ThirdCorner(const Triangulation& triangulation, int from, int to) {
  const std::span<const int> around = triangulation.NeighboursOf(from);
  const auto at = std::find(around.begin(), around.end(), to) - around.begin();
  return around[static_cast<size_t>(at + 1) % around.size()];
}

// A triangle on the hull is flat if its side there is longer, and its third corner less deep, than
// so many spacings of the seeds. Measured (NOTES.md); not sensitive.
constexpr double kMaxSideSpacings = 3;
constexpr double kMaxDepthSpacings = 1;

Result<Triangulation> CheckedTriangulation(std::span<const Seed> seeds) {
  // Appended, since GCC 14 warns of what + makes inside.
  const auto fail = [&](const char* why) {
    std::string text = std::to_string(seeds.size());
    text += why;
    return Fail(std::move(text));
  };
  if (seeds.size() < 3) return fail(" seeds: a prior needs at least 3");
  Triangulation triangulation = Triangulate(seeds);
  if (triangulation.triangles.empty()) return fail(" seeds, all on one line: no prior");
  return triangulation;
}

// Whether most of the ToF seeds are noisy.
bool AreNoisy(std::span<const Seed> seeds, const PriorConfig& config) {
  const auto noisy = std::count_if(seeds.begin(), seeds.end(), [&](const Seed& seed) {
    return seed.origin == SeedOrigin::kTof && IsNoisy(seed, config);
  });
  return 2 * noisy > CountTofSeeds(seeds);
}

void RenewMaps(PriorMap& map, cv::Size size) {
  Renew(map.disparity, size);
  Renew(map.sigma, size);
}

}  // namespace

void RemoveFlatTriangles(std::span<const Seed> seeds, double max_side_px, double max_depth_px,
                         Triangulation& triangulation) {
  if (triangulation.hull.empty()) return;
  std::vector<uint8_t> on_outline(seeds.size(), 0);
  for (const int seed : triangulation.hull) on_outline[static_cast<size_t>(seed)] = 1;
  const auto is_flat = [&](int from, int to, int third) {
    const Seed& a = seeds[static_cast<size_t>(from)];
    const Seed& b = seeds[static_cast<size_t>(to)];
    const Seed& c = seeds[static_cast<size_t>(third)];
    const double u = double{b.u} - a.u;
    const double v = double{b.v} - a.v;
    const double length = std::sqrt(u * u + v * v);
    return length > max_side_px && on_outline[static_cast<size_t>(third)] == 0 &&
           std::abs(u * (double{c.v} - a.v) - v * (double{c.u} - a.u)) < max_depth_px * length;
  };
  // The seeds of the hull that are still to be visited, the next one last.
  std::vector<int> ahead(triangulation.hull.rbegin(), triangulation.hull.rend());
  ahead.insert(ahead.begin(), ahead.back());
  std::vector<int> outline{ahead.back()};
  ahead.pop_back();
  std::vector<SeedTriangle> flat;
  while (!ahead.empty()) {
    const int from = outline.back();
    const int to = ahead.back();
    const int third = ThirdCorner(triangulation, from, to);
    if (is_flat(from, to, third)) {
      flat.push_back({from, to, third});
      on_outline[static_cast<size_t>(third)] = 1;
      ahead.push_back(third);
    } else {
      outline.push_back(to);
      ahead.pop_back();
    }
  }
  outline.pop_back();  // it is the first one
  triangulation.hull = outline;
  for (SeedTriangle& triangle : flat) std::sort(triangle.begin(), triangle.end());
  std::sort(flat.begin(), flat.end());
  std::erase_if(triangulation.triangles, [&](SeedTriangle triangle) {
    const auto& [a, b, c] = triangle;
    const auto is_on = [&](int seed) { return on_outline[static_cast<size_t>(seed)] != 0; };
    if (!is_on(a) || !is_on(b) || !is_on(c)) return false;
    std::sort(triangle.begin(), triangle.end());
    return std::binary_search(flat.begin(), flat.end(), triangle);
  });
}

// Memory of the last frame, kept for the next one: memory of this size is slow to get.
struct PriorEstimator::Memory {
  cv::Mat3b left_bgr;  // where an image had to be converted
  cv::Mat1b left_grey;
  cv::Mat1b right_grey;
  EdgeImages images;
  EdgeLabels labels;
  DisparityImage unfiltered;
  PriorMap result;
};

PriorEstimator::PriorEstimator(const PriorConfig& config)
    : config_(config), memory_(std::make_unique<Memory>()) {
  RequireInRange(config, "prior");
}

PriorEstimator::~PriorEstimator() = default;

Result<PriorMap> PriorEstimator::Compute(const cv::Mat& left, const cv::Mat& right,
                                         std::span<const Seed> seeds, cv::Size size,
                                         const cv::Mat1b& left_grey) {
  if (uses_images() && (left.size() != size || right.size() != size)) {
    return Fail("images of " + SizeText(left.size()) + " and " + SizeText(right.size()) +
                ": allowed is the calibrated size " + SizeText(size));
  }
  // Wider images than kMaxSide come from far points with negative disparities, which widen them.
  if (size.width > kMaxSide + kMaxColumns || size.height > kMaxSide) {
    return Fail("a prior of " + SizeText(size) + ": allowed are up to " + std::to_string(kMaxSide) +
                " pixels a side");
  }
  return uses_images() ? WithEdges(left, left_grey, right, seeds, size)
                       : InterpolateOnly(seeds, size);
}

// The paper's prior: linear interpolation alone.
Result<PriorMap> PriorEstimator::InterpolateOnly(std::span<const Seed> seeds, cv::Size size) {
  const Result<Triangulation> triangulation = CheckedTriangulation(seeds);
  if (!triangulation) return tl::unexpected(triangulation.error());
  std::vector<Plane> planes(seeds.size());
  std::transform(seeds.begin(), seeds.end(), planes.begin(), LevelPlane);
  PriorMap& result = memory_->result;
  RenewMaps(result, size);
  const auto done = Interpolate(planes, triangulation->triangles, config_.edge_px(), result);
  if (!done) return tl::unexpected(done.error());
  return result;
}

Result<PriorMap> PriorEstimator::WithEdges(const cv::Mat& left, const cv::Mat1b& left_grey,
                                           const cv::Mat& right, std::span<const Seed> seeds,
                                           cv::Size size) {
  Result<Triangulation> triangulation = CheckedTriangulation(seeds);
  if (!triangulation) return tl::unexpected(triangulation.error());
  EdgeImages& images = memory_->images;
  images.left_bgr = ToBgr(left, memory_->left_bgr);
  images.left_grey = left_grey.size() == size ? left_grey : ToGrey(left, memory_->left_grey);
  images.right_grey = ToGrey(right, memory_->right_grey);
  CensusTransform(images.left_grey, images.left_census);
  CensusTransform(images.right_grey, images.right_census);
  const double spacing_px = SpacingPx(seeds, triangulation->triangles);
  RemoveFlatTriangles(seeds, kMaxSideSpacings * spacing_px, kMaxDepthSpacings * spacing_px,
                      *triangulation);
  std::vector<SeedTriangle> triangles = triangulation->triangles;

  // Eqs. (P1) to (P3): a plane for each seed.
  const double step_px = StepPx(seeds, triangles, spacing_px, config_);
  std::vector<Plane> planes = FitPlanes(seeds, *triangulation, spacing_px, step_px, config_);
  ExtendBeyondHull(triangulation->hull, size, config_.border_spacings() * spacing_px, config_,
                   planes, triangles);

  // Eqs. (P4) and (P8): the paper's interpolation, and how sure it is.
  PriorMap& result = memory_->result;
  RenewMaps(result, size);
  const double edge_px = std::max(config_.edge_px(), step_px);
  const auto done = Interpolate(planes, triangles, edge_px, result);
  if (!done) return tl::unexpected(done.error());

  // Eqs. (P5) to (P7): near or far, in triangles across a depth edge.
  const std::vector<EdgeTriangle> edges =
      FindEdgeTriangles(planes, triangles, *triangulation, edge_px);
  PaintLabels(edges, planes, edge_px, size, memory_->labels);
  DecideLabels(memory_->labels, DataTerm(images, edges, planes, config_), result.disparity);

  if (AreNoisy(seeds, config_)) {  // single pixels that were decided otherwise than those around
    std::swap(result.disparity, memory_->unfiltered);
    Renew(result.disparity, size);
    FilterByMedian(memory_->unfiltered.counts(), result.disparity.counts());
  }
  return result;
}

}  // namespace sprout::prior
