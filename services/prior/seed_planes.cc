#include "services/prior/seed_planes.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "common/core/parallel.h"
#include "common/core/quantile.h"

namespace sprout::prior {
namespace {

constexpr int kIterations = 3;  // of reweighting; more make noisy seeds worse
// The first plane is level, and a slant must not look like another surface: its scale is wider.
constexpr double kFirstScale = 1.5;
// λ in (P1), against the weight 1 of a neighbour one spacing away: slopes that rest on the seeds of
// one line, as beside an edge, stay small across it, and others lose less than 1 %.
constexpr double kSlopeWeight = 0.004;
// Differences of up to two standard deviations are noise (95 % of them are).
constexpr double kScalePerSigma = 2;
// Two rings are usually 19 seeds; more than three times as many tell nothing new.
constexpr size_t kMostSupport = 64;

double Square(double x) { return x * x; }

// The Geman-McClure M-estimator: weight of a residual, ρ'(r) / r up to a factor.
double SupportWeight(double residual, double scale) {
  return 1 / Square(1 + Square(residual / scale));
}

// Weighted least squares for a plane, with a weight for level slopes.
class NormalEquations {
 public:
  explicit NormalEquations(double slope_weight) : xx_(slope_weight), yy_(slope_weight) {}

  // x, y: columns and rows from the plane's position.
  void Add(double weight, double x, double y, double d) {
    n_ += weight;
    x_ += weight * x;
    y_ += weight * y;
    xx_ += weight * x * x;
    xy_ += weight * x * y;
    yy_ += weight * y * y;
    d_ += weight * d;
    dx_ += weight * x * d;
    dy_ += weight * y * d;
  }

  // For the disparity first, with the slopes eliminated.
  void SolveInto(Plane& plane) const {
    const double determinant = xx_ * yy_ - xy_ * xy_;
    const double p = (yy_ * x_ - xy_ * y_) / determinant;
    const double q = (xx_ * y_ - xy_ * x_) / determinant;
    const double disparity = (d_ - p * dx_ - q * dy_) / (n_ - p * x_ - q * y_);
    const double right_x = dx_ - x_ * disparity;
    const double right_y = dy_ - y_ * disparity;
    plane.disparity = static_cast<float>(disparity);
    plane.per_column = static_cast<float>((yy_ * right_x - xy_ * right_y) / determinant);
    plane.per_row = static_cast<float>((xx_ * right_y - xy_ * right_x) / determinant);
  }

 private:
  double n_ = 0;
  double x_ = 0;
  double y_ = 0;
  double xx_;
  double xy_ = 0;
  double yy_;
  double d_ = 0;
  double dx_ = 0;
  double dy_ = 0;
};

// w in (P1): how much less a seed counts that is less sure than the one whose plane it is. What
// lies below σ₀ is not told apart.
double SureWeight(double sigma_px, double other_sigma_px) {
  constexpr double kSurePx = 0.1;
  return (Square(kSurePx) + Square(sigma_px)) / (Square(kSurePx) + Square(other_sigma_px));
}

// The least-squares plane at a seed whose support weighs by its residuals to `plane`.
Plane Refit(const Plane& plane, std::span<const Seed> seeds, std::span<const int> support,
            double scale, double slope_weight) {
  NormalEquations equations(slope_weight);
  for (int i : support) {
    const Seed& seed = seeds[static_cast<size_t>(i)];
    const double residual = double{seed.disparity()} - plane.At(seed.u, seed.v);
    const double weight =
        SupportWeight(residual, scale) * SureWeight(plane.sigma_px, seed.sigma_px);
    equations.Add(weight, double{seed.u} - plane.u, double{seed.v} - plane.v, seed.disparity());
  }
  Plane refit = plane;
  equations.SolveInto(refit);
  return refit;
}

// Steps are taken off with seeds that differ by about one: those a step off have a weight of 0.3,
// two steps off 0.05. Without steps by what is too fine to matter.
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
  constexpr double kHardlyAny = 0.1;
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
  return differences.empty() ? 0 : Quantile(differences, kHardlyAny);
}

std::vector<Plane> FitPlanes(std::span<const Seed> seeds, const Triangulation& triangulation,
                             double spacing_px, double step_px, const PriorConfig& config) {
  const double least_scale_px = LeastScalePx(spacing_px, config);
  const double step_scale_px = StepScalePx(step_px);
  const double slope_weight = kSlopeWeight * Square(spacing_px);
  const auto fit = [&](int k, Rings& rings) {
    const Seed& seed = seeds[static_cast<size_t>(k)];
    const bool noisy = IsNoisy(seed, config);
    const double noise_px = kScalePerSigma * seed.sigma_px;
    const std::span<const int> support =
        rings.Around(std::span(&k, 1), noisy ? 2 : 1, kMostSupport);
    // Eq. (P2): the scale s.
    const double scale_px = std::max(least_scale_px, noise_px);
    // Eq. (P1), by iteratively reweighted least squares.
    Plane plane = Refit(LevelPlane(seed), seeds, support, kFirstScale * scale_px, slope_weight);
    for (int i = 1; i < kIterations; ++i) {
      plane = Refit(plane, seeds, support, scale_px, slope_weight);
    }
    if (noisy) return plane;
    // Eq. (P3): an accurate seed gives way to seeds that differ from it by a step only.
    const double near_px = std::max(step_scale_px, noise_px);
    plane.disparity = Refit(LevelPlane(seed), seeds, support, near_px, slope_weight).disparity;
    return plane;
  };
  std::vector<Plane> planes(seeds.size());
  const auto count = static_cast<int>(seeds.size());
  ForRangesParallel(count, 4 * cv::getNumThreads(), [&](const cv::Range& part) {
    Rings rings(triangulation);
    for (int k = part.start; k < part.end; ++k) planes[static_cast<size_t>(k)] = fit(k, rings);
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
