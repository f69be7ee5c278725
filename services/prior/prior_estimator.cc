#include "services/prior/prior_estimator.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "common/core/image.h"
#include "common/core/parallel.h"
#include "services/prior/census.h"
#include "services/prior/edge_judge.h"
#include "services/prior/edges.h"
#include "services/prior/seed_spreading.h"
#include "services/prior/sigma_map.h"

namespace sprout {
namespace {

// Of seeds that are spread evenly.
double SpacingPx(size_t seeds, cv::Size size) {
  return std::sqrt(size.area() / std::max(1.0, static_cast<double>(seeds)));
}

// Seeds with the disparities of the surface that was fitted to them.
void PutSeedsOn(const SeedSurface& surface, std::vector<Seed>& seeds) {
  seeds.clear();
  seeds.reserve(surface.planes.size());
  for (const LocalPlane& plane : surface.planes) {
    seeds.push_back({.u = plane.u, .v = plane.v, .u_right = plane.u - plane.disparity});
  }
}

// Slants go on beyond the last seeds, but not to where nothing was seen: at most so far beyond the
// farthest and the nearest seed.
void HoldWithin(std::span<const Seed> seeds, DisparityImage& map) {
  constexpr double kBeyondPx = 1;  // what seeds themselves are off, and no more than growth may add
  const auto [farthest, nearest] = std::minmax_element(
      seeds.begin(), seeds.end(),
      [](const Seed& a, const Seed& b) { return a.disparity() < b.disparity(); });
  const auto counts = [](double px) {
    return ToCounts(std::clamp(px, 0.0, DisparityImage::kMaxPx));
  };
  const int16_t least = counts(farthest->disparity() - kBeyondPx);
  const int16_t most = counts(nearest->disparity() + kBeyondPx);
  for (int v = 0; v < map.height(); ++v) {
    int16_t* const row = map.counts()[v];
    for (int u = 0; u < map.width(); ++u) row[u] = std::clamp(row[u], least, most);
  }
}

// The seeds as they are.
void LevelPlanes(std::span<const Seed> seeds, std::vector<LocalPlane>& planes) {
  planes.clear();
  for (const Seed& seed : seeds) {
    planes.push_back(
        {.u = seed.u, .v = seed.v, .disparity = seed.disparity(), .sigma_px = seed.sigma_px});
  }
}

}  // namespace

PriorEstimator::PriorEstimator(const PriorConfig& config) : config_(config) {
  RequireInRange(config, "prior");
}

Result<PriorMap> PriorEstimator::Compute(const cv::Mat& left, const cv::Mat& right,
                                         std::span<const Seed> seeds, cv::Size size) {
  const Result<DisparityImage> disparity = Disparities(left, right, seeds, size);
  if (!disparity) return tl::unexpected(disparity.error());
  return PriorMap(*disparity, sigma_);
}

Result<DisparityImage> PriorEstimator::Disparities(const cv::Mat& left, const cv::Mat& right,
                                                   std::span<const Seed> seeds, cv::Size size) {
  if ((uses_left() && left.size() != size) || (uses_right() && right.size() != size)) {
    return Fail("images of " + SizeText(left.size()) + " and " + SizeText(right.size()) +
                ": allowed is the calibrated size " + SizeText(size));
  }
  if (std::max(size.width, size.height) > kLargestSide) {
    return Fail("a prior of " + SizeText(size) + ": allowed are up to " +
                std::to_string(kLargestSide) + " pixels a side");
  }
  if (config_.method() == PriorConfig::EDGES) return WithEdges(left, right, seeds, size);
  Renew(result_, size);
  Renew(sigma_, size);
  const bool spreads = config_.method() == PriorConfig::FGS;
  DisparityImage& interpolated = spreads ? interpolated_ : result_;
  const std::span<const SeedTriangle> triangles = triangulator_.Triangulate(seeds);
  const Result<DisparityImage> map =
      interpolator_.Interpolate(seeds, triangles, size, interpolated);
  if (!map) return map;
  LevelPlanes(seeds, level_planes_);
  PaintSigma(level_planes_, triangles, size, sigma_);
  if (!spreads) return map;
  interpolated_ = *map;
  SpreadOver(left, seeds);
  return result_;
}

// The result: spread seeds, and where none reaches the interpolation.
void PriorEstimator::SpreadOver(const cv::Mat& left, std::span<const Seed> seeds) {
  const cv::Mat1f spread_px = SpreadSeeds(seeds, left, config_.fgs_lambda(), config_.fgs_sigma());
  for (int v = 0; v < spread_px.rows; ++v) {
    for (int u = 0; u < spread_px.cols; ++u) {
      const int16_t counts = ToCounts(spread_px(v, u));
      result_.counts()(v, u) =
          counts != DisparityImage::kInvalid ? counts : interpolated_.counts()(v, u);
    }
  }
}

Result<DisparityImage> PriorEstimator::WithEdges(const cv::Mat& left, const cv::Mat& right,
                                                 std::span<const Seed> seeds, cv::Size size) {
  EdgeEvidence evidence;
  evidence.left_grey = ToGrey(left, images_.left_grey);
  evidence.right_grey = ToGrey(right, images_.right_grey);
  CensusTransform(evidence.left_grey, images_.left_census);
  CensusTransform(evidence.right_grey, images_.right_census);
  const std::span<const SeedTriangle> seed_triangles = triangulator_.Triangulate(seeds);
  const std::span<const int> hull = config_.extend_to_border()
                                        ? std::span<const int>(triangulator_.hull())
                                        : std::span<const int>();
  const double spacing_px = SpacingPx(seeds.size(), size);
  const auto& [surface, triangles] =
      extender_.Extend(fitter_.Fit(seeds, seed_triangles, config_.noisy_px(), config_.edge_px()),
                       seed_triangles, hull, size, /*reach_px=*/2 * spacing_px);
  PutSeedsOn(surface, fitted_seeds_);
  Renew(interpolated_, size);
  const Result<DisparityImage> interpolated =
      interpolator_.Interpolate(fitted_seeds_, triangles, size, interpolated_);
  if (!interpolated) return interpolated;
  interpolated_ = *interpolated;
  Renew(sigma_, size);
  PaintSigma(surface.planes, triangles, size, sigma_);
  const double noise_px = surface.noise_px > config_.noisy_px() ? surface.noise_px : 0;
  const std::span<const EdgeTriangle> edges =
      edge_finder_.Find(surface, triangles, fitter_.neighbours(),
                        std::max(config_.edge_px() + 2 * noise_px, surface.step_px));
  PaintEdgeHypotheses(edges, size, hypotheses_);
  evidence.left_bgr = ToBgr(left, images_.left_bgr);
  seed_votes_.Look(edges, surface.planes, spacing_px, evidence.left_bgr);
  evidence.left_census = images_.left_census;
  evidence.right_census = images_.right_census;
  evidence.seeds = &seed_votes_;
  evidence.weights = {config_.census_weight(), config_.colour_weight(), config_.proximity_weight()};
  ResolveEdges(hypotheses_, EdgeJudge(evidence), interpolated_);
  if (noise_px == 0) {
    std::swap(interpolated_, result_);
  } else {
    // Single pixels that were judged otherwise than those around them.
    Renew(result_, size);
    median_.Apply(interpolated_.counts(), result_.counts());
  }
  HoldWithin(seeds, result_);
  return result_;
}

}  // namespace sprout
