#include "services/prior/edges/seed_planes.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "common/core/parallel.h"
#include "common/core/quantile.h"
#include "services/prior/edges/plane_kernel.h"

namespace sprout::prior {
namespace {

// λ in (P1), against the weight 1 of a neighbour one spacing away: slopes that rest on the seeds of
// one line, as beside an edge, stay small across it, and others lose less than 1 %.
constexpr double kSlopeWeight = 0.004;
// Differences of up to two standard deviations are noise (95 % of them are).
constexpr double kScalePerSigma = 2;
// Two rings are usually 19 seeds; more than three times as many tell nothing new.
constexpr size_t kMaxSupport = PlaneFits::kMaxSupport;

double Square(double x) { return x * x; }

// Steps are taken off with seeds that differ by about one: those a step off have a weight of 0.3,
// two steps off 0.05. If disparities have no steps, the scale is too fine to matter.
double StepScalePx(double step_px) {
  constexpr double kScalePerStep = 1.1;
  constexpr double kFinePx = 0.1;
  return std::max(kScalePerStep * step_px, kFinePx);
}

// Eq. (P2) without the noise.
double LeastScalePx(double spacing_px, const PriorConfig& config) {
  return std::max(config.plane_scale_px(), config.plane_scale_per_spacing() * spacing_px);
}

}  // namespace

double SpacingPx(std::span<const Seed> seeds, std::span<const SeedTriangle> triangles) {
  std::vector<double> squares;
  squares.reserve(3 * triangles.size());
  for (const SeedTriangle& triangle : triangles) {
    for (size_t i = 0; i < 3; ++i) {
      const Seed& a = seeds[static_cast<size_t>(triangle[i])];
      const Seed& b = seeds[static_cast<size_t>(triangle[(i + 1) % 3])];
      squares.push_back(Square(double{b.u} - a.u) + Square(double{b.v} - a.v));
    }
  }
  return squares.empty() ? 1 : std::sqrt(Median(squares));
}

double StepPx(std::span<const Seed> seeds, std::span<const SeedTriangle> triangles,
              double spacing_px, const PriorConfig& config) {
  constexpr double kEqualPx = 1e-3;  // u − u' of floats is off by as much
  // Seeds that far off a plane weigh less than 2 % in (P1): they are on another surface.
  const double surface_px = 2.5 * LeastScalePx(spacing_px, config);
  std::vector<double> differences;
  for (const SeedTriangle& triangle : triangles) {
    const Seed& a = seeds[static_cast<size_t>(triangle[0])];
    const Seed& b = seeds[static_cast<size_t>(triangle[1])];
    if (a.origin != SeedOrigin::kTof || b.origin != SeedOrigin::kTof) continue;
    const double difference = std::abs(double{a.disparity()} - b.disparity());
    if (difference > kEqualPx && difference < surface_px) differences.push_back(difference);
  }
  return differences.empty() ? 0 : Quantile(differences, 0.1);
}

std::vector<Plane> FitPlanes(std::span<const Seed> seeds, const Triangulation& triangulation,
                             double spacing_px, double step_px, const PriorConfig& config) {
  const double least_scale_px = LeastScalePx(spacing_px, config);
  const double step_scale_px = StepScalePx(step_px);
  const double slope_weight = kSlopeWeight * Square(spacing_px);
  std::vector<Plane> planes(seeds.size());
  std::transform(seeds.begin(), seeds.end(), planes.begin(), LevelPlane);
  const auto count = static_cast<int>(seeds.size());
  ForRangesParallel(count, 4 * cv::getNumThreads(), [&](const cv::Range& part) {
    Rings rings(triangulation);
    PlaneFits fits;
    for (int first = part.start; first < part.end; first += PlaneFits::kAtOnce) {
      const int last = std::min(first + PlaneFits::kAtOnce, part.end) - 1;
      fits.most_support = 0;
      for (int lane = 0; lane < PlaneFits::kAtOnce; ++lane) {
        const int k = std::min(first + lane, last);  // behind the last one it is done again
        const Seed& seed = seeds[static_cast<size_t>(k)];
        const bool noisy = IsNoisy(seed, config);
        const double noise_px = kScalePerSigma * seed.sigma_px;
        const auto at = static_cast<size_t>(lane);
        fits.scale_px[at] = std::max(least_scale_px, noise_px);  // Eq. (P2)
        // Eq. (P3): an accurate seed gives way to seeds that differ from it by a step only.
        fits.near_px[at] = noisy ? 0 : std::max(step_scale_px, noise_px);
        fits.planes[at] = planes[static_cast<size_t>(k)];
        fits.SetSupport(at, seeds, rings.Around(std::span(&k, 1), noisy ? 2 : 1, kMaxSupport));
      }
      FitPlanesAtOnce(slope_weight, fits);  // Eq. (P1)
      std::copy_n(fits.planes.begin(), last + 1 - first, planes.begin() + first);
    }
  });
  return planes;
}

namespace {

// The direction outwards at a seed of the hull, between its sides' normals; so long that the copies
// of the hull's sides run one px outside of them, but at most 2 px at sharp corners.
cv::Point2d Outwards(const Plane& before, const Plane& seed, const Plane& behind) {
  const auto normal = [](const Plane& a, const Plane& b) {
    const cv::Point2d across(double{b.v} - a.v, double{a.u} - b.u);
    return across / std::max(std::hypot(across.x, across.y), 1e-9);
  };
  const cv::Point2d sum = normal(before, seed) + normal(seed, behind);
  return sum * (2 / std::max(sum.dot(sum), 1.0));
}

}  // namespace

void ExtendBeyondHull(std::span<const int> hull, cv::Size size, double reach_px,
                      const PriorConfig& config, std::vector<Plane>& planes,
                      std::vector<SeedTriangle>& triangles) {
  const auto plane_at = [&](size_t i) {
    return planes[static_cast<size_t>(hull[i % hull.size()])];
  };
  const auto first = static_cast<int>(planes.size());
  for (size_t i = 0; i < hull.size(); ++i) {
    Plane copy = plane_at(i);
    const cv::Point2d outwards = Outwards(plane_at(i + hull.size() - 1), copy, plane_at(i + 1));
    // Seeds beyond the border stay where they are.
    const auto move = [&](float from, double by, int length) {
      const auto last = static_cast<float>(length - 1);
      return std::clamp(static_cast<float>(from + by * reach_px), std::min(from, 0.F),
                        std::max(from, last));
    };
    const float u = move(copy.u, outwards.x, size.width);
    const float v = move(copy.v, outwards.y, size.height);
    // Eq. (P8). No two images show disparities beyond their width.
    copy.sigma_px = static_cast<float>(
        std::hypot(copy.sigma_px, config.slope_sigma() * std::hypot(u - copy.u, v - copy.v)));
    copy.disparity = std::clamp(copy.At(u, v), 0.F, static_cast<float>(size.width - 1));
    copy.u = u;
    copy.v = v;
    planes.push_back(copy);
  }
  const auto count = static_cast<int>(hull.size());
  for (int i = 0; i < count; ++i) {
    const int next = (i + 1) % count;
    const int a = hull[static_cast<size_t>(i)];
    const int b = hull[static_cast<size_t>(next)];
    triangles.push_back({a, b, first + next});
    triangles.push_back({a, first + next, first + i});
  }
}

}  // namespace sprout::prior
