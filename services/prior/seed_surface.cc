#include "services/prior/seed_surface.h"

#include <algorithm>
#include <cmath>

#include "common/core/parallel.h"

namespace sprout {
namespace {

constexpr int kIterations = 3;        // of reweighting; more make noisy seeds worse
constexpr double kSlopeHold = 0.004;  // weight of "no slope" against that of one neighbour
// Disparities that far off a plane count a quarter: so many px for a seed's spacing of one, since a
// slant puts neighbours the farther off the farther they are; but at least so many px.
constexpr double kScalePerSpacing = 0.12;
constexpr double kSmallestScalePx = 0.4;
constexpr double kScalePerNoise = 2;  // and so many standard deviations of the noise
// The same where steps are smoothed: in steps, and at least.
constexpr double kScalePerStep = 1.1;
constexpr double kSmallestSmoothPx = 0.1;
// Seeds whose surface differs by less than this over their neighbours do not show whether it is
// level or slanted.
constexpr double kTellingPx = 1.1;
// What differs by more is another surface: so many px for a seed's spacing of one, but at least.
constexpr double kOtherSurfacePerSpacing = 0.2;
constexpr double kOtherSurfacePx = 3;

// Seeds that a plane is fitted to; three steps of the triangulation are usually 37.
constexpr size_t kMostSupport = 64;

bool IsTof(const Seed& seed) { return seed.origin == SeedOrigin::kTof; }

size_t Index(int i) { return static_cast<size_t>(i); }

// The value that a share of the others does not reach; 0 when there are none. Reorders them.
double Quantile(std::vector<double>& values, double share) {
  if (values.empty()) return 0;
  const auto rank = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size()));
  std::nth_element(values.begin(), values.begin() + rank, values.end());
  return values[static_cast<size_t>(rank)];
}

// The plane d(x, y) = value + x·per_x + y·per_y.
struct Plane {
  double value = 0;
  double per_x = 0;
  double per_y = 0;

  double At(double x, double y) const { return value + per_x * x + per_y * y; }
};

// Weighted least squares for a plane.
class PlaneSums {
 public:
  // The weights of the prior plane d = 0: of its value, and of each slope.
  PlaneSums(double value_hold, double slope_hold) : n_(value_hold), xx_(slope_hold), yy_(xx_) {}

  void Add(double weight, double x, double y, double d) {
    const double wx = weight * x;
    const double wy = weight * y;
    n_ += weight;
    x_ += wx;
    y_ += wy;
    xx_ += wx * x;
    xy_ += wx * y;
    yy_ += wy * y;
    d_ += weight * d;
    dx_ += wx * d;
    dy_ += wy * d;
  }

  // Solves the normal equations for the value first, with the slopes eliminated.
  Plane Solve() const {
    const double per_area = 1 / (xx_ * yy_ - xy_ * xy_);
    const double p = (yy_ * x_ - xy_ * y_) * per_area;
    const double q = (xx_ * y_ - xy_ * x_) * per_area;
    Plane plane;
    plane.value = (d_ - p * dx_ - q * dy_) / (n_ - p * x_ - q * y_);
    const double right_x = dx_ - x_ * plane.value;
    const double right_y = dy_ - y_ * plane.value;
    plane.per_x = (yy_ * right_x - xy_ * right_y) * per_area;
    plane.per_y = (xx_ * right_y - xy_ * right_x) * per_area;
    return plane;
  }

 private:
  double n_;
  double x_ = 0;
  double y_ = 0;
  double xx_;
  double xy_ = 0;
  double yy_;
  double d_ = 0;
  double dx_ = 0;
  double dy_ = 0;
};

// Fits planes around seeds, with their spacing as unit of x and y.
class PlaneFitter {
 public:
  PlaneFitter(std::span<const Seed> seeds, double spacing_px)
      : seeds_(seeds), per_px_(1 / spacing_px) {}

  // @param support  of Surroundings.
  LocalPlane Fit(int seed, std::span<const int> support, double scale_px) const {
    const double per_scale = 1 / scale_px;
    Plane plane{.value = seeds_[Index(seed)].disparity()};
    for (int iteration = 0; iteration < kIterations; ++iteration) {
      // The first plane is level: a slant must not look like another surface.
      const double sharpness = iteration == 0 ? per_scale / 1.5 : per_scale;
      PlaneSums sums(1e-9, kSlopeHold);
      for (int i : support) {
        const Point point = From(seed, i);
        AddSoftly(point.disparity - plane.At(point.x, point.y), sharpness, point, sums);
      }
      plane = sums.Solve();
    }
    return ToLocal(seed, plane);
  }

  // The plane through those of a seed's support that differ little from it: takes the steps off in
  // which disparities are counted.
  LocalPlane Smooth(int seed, std::span<const int> support, double scale_px) const {
    const double own = seeds_[Index(seed)].disparity();
    PlaneSums sums(1e-9, kSlopeHold);
    for (int i : support) {
      const Point point = From(seed, i);
      AddSoftly(point.disparity - own, 1 / scale_px, point, sums);
    }
    return ToLocal(seed, sums.Solve());
  }

  // Whether the support shows more than one or two steps of a seed's surface.
  bool IsTelling(int seed, std::span<const int> support, double other_surface_px) const {
    const double own = seeds_[Index(seed)].disparity();
    double least = own;
    double most = own;
    for (int i : support) {
      const double disparity = seeds_[Index(i)].disparity();
      if (std::abs(disparity - own) > other_surface_px) continue;
      least = std::min(least, disparity);
      most = std::max(most, disparity);
      if (most - least > kTellingPx) return true;
    }
    return false;
  }

 private:
  struct Point {
    double x;
    double y;
    double disparity;
  };

  LocalPlane ToLocal(int seed, const Plane& plane) const {
    const Seed& centre = seeds_[Index(seed)];
    return {centre.u,
            centre.v,
            static_cast<float>(plane.value),
            static_cast<float>(plane.per_x * per_px_),
            static_cast<float>(plane.per_y * per_px_),
            centre.sigma_px};
  }

  // With the Geman-McClure weight of a point that is `off` px off.
  static void AddSoftly(double off, double sharpness, const Point& point, PlaneSums& sums) {
    const double weight = 1 / (1 + off * off * (sharpness * sharpness));
    sums.Add(weight * weight, point.x, point.y, point.disparity);
  }

  Point From(int centre, int seed) const {
    const Seed& from = seeds_[Index(centre)];
    const Seed& to = seeds_[Index(seed)];
    return {(double{to.u} - from.u) * per_px_, (double{to.v} - from.v) * per_px_, to.disparity()};
  }

  std::span<const Seed> seeds_;
  double per_px_;  // of the unit
};

// Median side of the triangles.
// @param squares  memory.
double SpacingPx(std::span<const Seed> seeds, std::span<const SeedTriangle> triangles,
                 std::vector<double>& squares) {
  squares.clear();
  squares.reserve(3 * triangles.size());
  const auto add = [&](int a, int b) {
    const double across = double{seeds[Index(b)].u} - seeds[Index(a)].u;
    const double down = double{seeds[Index(b)].v} - seeds[Index(a)].v;
    squares.push_back(across * across + down * down);
  };
  for (const auto& [a, b, c] : triangles) {
    add(a, b);
    add(b, c);
    add(c, a);
  }
  return squares.empty() ? 1 : std::sqrt(Quantile(squares, 0.5));
}

// The steps in which the ToF seeds' disparities are counted, or a small number if they are not:
// hardly any two neighbours on a surface differ by less, unless they are equal.
// @param differences  memory.
double StepPx(std::span<const Seed> seeds, std::span<const SeedTriangle> triangles,
              double other_surface_px, std::vector<double>& differences) {
  constexpr double kEqualPx = 1e-3;
  constexpr double kHardlyAny = 0.1;
  differences.clear();
  differences.reserve(triangles.size());
  for (const auto& [a, b, c] : triangles) {
    const double difference =
        std::abs(double{seeds[Index(a)].disparity()} - seeds[Index(b)].disparity());
    if (!IsTof(seeds[Index(a)]) || !IsTof(seeds[Index(b)])) continue;
    if (difference > kEqualPx && difference < other_surface_px) differences.push_back(difference);
  }
  return Quantile(differences, kHardlyAny);
}

// Of the ToF seeds, as they say: the median.
// @param sigmas  memory.
double NoisePx(std::span<const Seed> seeds, std::vector<double>& sigmas) {
  sigmas.clear();
  for (const Seed& seed : seeds) {
    if (IsTof(seed)) sigmas.push_back(seed.sigma_px);
  }
  return Quantile(sigmas, 0.5);
}

// For each seed, whether it is in a triangle whose disparities differ by at least `edge_px`.
void FindSeedsAtEdges(std::span<const Seed> seeds, std::span<const SeedTriangle> triangles,
                      double edge_px, std::vector<uint8_t>& at_edge) {
  at_edge.assign(seeds.size(), 0);
  for (const SeedTriangle& triangle : triangles) {
    const auto disparity = [&](int corner) {
      return seeds[Index(triangle[Index(corner)])].disparity();
    };
    const auto [least, most] = std::minmax({disparity(0), disparity(1), disparity(2)});
    if (double{most} - least < edge_px) continue;
    for (int seed : triangle) at_edge[Index(seed)] = 1;
  }
}

}  // namespace

struct SeedSurfaceFitter::Memory {
  SeedNeighbours neighbours;
  std::vector<double> squares;
  std::vector<double> differences;
  std::vector<double> sigmas;
  std::vector<uint8_t> at_edge;
  std::vector<Surroundings> surroundings;  // one a part
  SeedSurface surface;
};

SeedSurfaceFitter::SeedSurfaceFitter() : memory_(std::make_unique<Memory>()) {}
SeedSurfaceFitter::~SeedSurfaceFitter() = default;

const SeedNeighbours& SeedSurfaceFitter::neighbours() const { return memory_->neighbours; }

const SeedSurface& SeedSurfaceFitter::Fit(std::span<const Seed> seeds,
                                          std::span<const SeedTriangle> triangles, double noisy_px,
                                          double edge_px) {
  const SeedNeighbours& neighbours = memory_->neighbours;
  double spacing_px = 0;
  double other_surface_px = 0;
  SeedSurface& surface = memory_->surface;
  RunBoth([&] { memory_->neighbours.Find(seeds.size(), triangles); },
          [&] {
            spacing_px = SpacingPx(seeds, triangles, memory_->squares);
            other_surface_px = std::max(kOtherSurfacePx, kOtherSurfacePerSpacing * spacing_px);
            surface.step_px = StepPx(seeds, triangles, other_surface_px, memory_->differences);
            FindSeedsAtEdges(seeds, triangles, edge_px, memory_->at_edge);
          });
  const PlaneFitter fitter(seeds, spacing_px);
  surface.noise_px = NoisePx(seeds, memory_->sigmas);
  const bool noisy = surface.noise_px > noisy_px;
  const double scale_px = std::max(
      {kSmallestScalePx, kScalePerSpacing * spacing_px, kScalePerNoise * surface.noise_px});
  const auto stereo_scale_px = [&](int i) {
    return std::max({kSmallestScalePx, kScalePerSpacing * spacing_px,
                     kScalePerNoise * seeds[Index(i)].sigma_px});
  };
  const double smooth_px = std::max(
      {kSmallestSmoothPx, kScalePerStep * surface.step_px, kScalePerNoise * surface.noise_px});
  surface.planes.resize(seeds.size());
  const auto has_neighbour_at_edge = [&](int i) {
    const std::span<const int> around = neighbours.Of(i);
    return std::any_of(around.begin(), around.end(),
                       [&](int neighbour) { return memory_->at_edge[Index(neighbour)] != 0; });
  };
  const auto fit = [&](int i, Surroundings& around) {
    LocalPlane& plane = surface.planes[Index(i)];
    around.Start(std::span(&i, 1));
    around.Widen(kMostSupport);
    // A seed of stereo errs for itself, as a noisy ToF point does; those around it know better.
    const bool is_stereo = !IsTof(seeds[Index(i)]);
    if (noisy || is_stereo) {
      around.Widen(kMostSupport);
      plane = fitter.Fit(i, around.reached(), is_stereo ? stereo_scale_px(i) : scale_px);
      return;
    }
    const bool beside_edge = has_neighbour_at_edge(i);
    if (beside_edge) plane = fitter.Fit(i, around.reached(), scale_px);
    if (!fitter.IsTelling(i, around.reached(), other_surface_px)) around.Widen(kMostSupport);
    const LocalPlane smooth = fitter.Smooth(i, around.reached(), smooth_px);
    if (beside_edge) {
      plane.disparity = smooth.disparity;
    } else {
      plane = smooth;
    }
  };
  constexpr size_t kParts = 16;  // seeds at edges, of which some parts have more, take longer
  memory_->surroundings.resize(kParts);
  ForEachParallel(kParts, [&](size_t part) {
    Surroundings& surroundings = memory_->surroundings[part];
    surroundings.Set(neighbours);
    const size_t end = seeds.size() * (part + 1) / kParts;
    for (size_t i = seeds.size() * part / kParts; i < end; ++i) {
      fit(static_cast<int>(i), surroundings);
    }
  });
  return surface;
}

}  // namespace sprout
