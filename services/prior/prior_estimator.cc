#include "services/prior/prior_estimator.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <string>
#include <utility>
#include <vector>

#include "common/core/image.h"
#include "common/core/parallel.h"
#include "services/prior/delaunay.h"
#include "services/prior/edges.h"
#include "services/prior/interpolation.h"
#include "services/prior/seed_spreading.h"
#include "services/prior/seed_surface.h"

namespace sprout {
namespace {

cv::Mat3b ToBgr(const cv::Mat& image) {
  if (image.channels() == 3) return image;
  cv::Mat3b bgr;
  cv::cvtColor(image, bgr, cv::COLOR_GRAY2BGR);
  return bgr;
}

// Seeds with the disparities of the surface that was fitted to them.
std::vector<Seed> SeedsOn(const SeedSurface& surface) {
  std::vector<Seed> seeds;
  seeds.reserve(surface.planes.size());
  for (const LocalPlane& plane : surface.planes) {
    seeds.push_back({.u = plane.u, .v = plane.v, .u_right = plane.u - plane.disparity});
  }
  return seeds;
}

// cv::medianBlur(), on OpenCV's threads.
void TakeMedians(const cv::Mat1s& from, cv::Mat1s& to) {
  constexpr int kWindow = 5;
  PaintInBands(from.rows, [&](const cv::Range& rows) {
    const int first = std::max(rows.start - kWindow / 2, 0);
    const int end = std::min(rows.end + kWindow / 2, from.rows);
    cv::Mat1s medians;
    cv::medianBlur(from.rowRange(first, end), medians, kWindow);
    medians.rowRange(rows.start - first, rows.end - first).copyTo(to.rowRange(rows));
  });
}

}  // namespace

PriorEstimator::PriorEstimator(const PriorConfig& config) : config_(config) {
  RequireInRange(config, "prior");
}

Result<DisparityImage> PriorEstimator::Compute(const cv::Mat& left, const cv::Mat& right,
                                               std::span<const Seed> seeds, cv::Size size) {
  if ((uses_left() && left.size() != size) || (uses_right() && right.size() != size)) {
    return Fail("images of " + SizeText(left.size()) + " and " + SizeText(right.size()) +
                ": allowed is the calibrated size " + SizeText(size));
  }
  if (config_.method() == PriorConfig::EDGES) return WithEdges(left, right, seeds, size);
  Result<DisparityImage> prior = InterpolateSeeds(seeds, TriangulateSeeds(seeds), size);
  if (prior && config_.method() == PriorConfig::FGS) return FromSpreadSeeds(left, seeds, *prior);
  return prior;
}

DisparityImage PriorEstimator::FromSpreadSeeds(const cv::Mat& left, std::span<const Seed> seeds,
                                               const DisparityImage& interpolated) const {
  DisparityImage prior =
      FromPx(SpreadSeeds(seeds, left, config_.fgs_lambda(), config_.fgs_sigma()));
  // Where no seed reaches.
  interpolated.counts().copyTo(prior.counts(), prior.counts() == DisparityImage::kInvalid);
  return prior;
}

Result<DisparityImage> PriorEstimator::WithEdges(const cv::Mat& left, const cv::Mat& right,
                                                 std::span<const Seed> seeds, cv::Size size) {
  EdgeEvidence evidence;
  const auto look = [&] {
    evidence.spread_weight = config_.spread_weight();
    evidence.left_bgr = ToBgr(left);
    evidence.left_grey = ToGrey(left);
    evidence.right_grey = ToGrey(right);
    const cv::Mat half = HalfSize(left);
    evidence.half_bgr = ToBgr(half);
    evidence.spread_px =
        SpreadSeedsAtHalfSize(seeds, half, config_.fgs_lambda(), config_.fgs_sigma());
  };
  std::vector<SeedTriangle> triangles;
  RunBoth(look, [&] { triangles = TriangulateSeeds(seeds); });

  const SeedSurface surface =
      FitSeedSurface(seeds, triangles, config_.noisy_px(), config_.edge_px());
  const Result<DisparityImage> interpolated =
      InterpolateSeeds(SeedsOn(surface), triangles, size, prior_);
  if (!interpolated) return interpolated;
  prior_ = *interpolated;
  const double noise_px = surface.noise_px > config_.noisy_px() ? surface.noise_px : 0;
  PaintEdgeHypotheses(surface, triangles, config_.edge_px() + 2 * noise_px, size, hypotheses_);
  ResolveEdges(hypotheses_, EdgeJudge(evidence), prior_);
  // Single pixels that were judged otherwise than those around them.
  DisparityImage cleaned{cv::Mat1s(size)};
  TakeMedians(prior_.counts(), cleaned.counts());
  return cleaned;
}

}  // namespace sprout
