#include "services/prior/seed_surface.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <opencv2/core/utility.hpp>

namespace sprout {
namespace {

constexpr int kIterations = 4;          // of reweighting; more change nothing that can be measured
constexpr double kSlopeHold = 0.01;     // weight of "no slope" against that of one neighbour
constexpr double kSmallestScalePx = 1;  // disparities that far off count a quarter

size_t Index(int i) { return static_cast<size_t>(i); }

// For each seed those that it shares a triangle with, in ascending order.
class Neighbours {
 public:
  Neighbours(size_t seeds, std::span<const SeedTriangle> triangles) : of_(seeds) {
    for (const SeedTriangle& triangle : triangles) {
      for (int a : triangle) {
        for (int b : triangle) {
          if (a != b) of_[Index(a)].push_back(b);
        }
      }
    }
    for (std::vector<int>& list : of_) {
      std::sort(list.begin(), list.end());
      list.erase(std::unique(list.begin(), list.end()), list.end());
    }
  }

  const std::vector<int>& Of(int seed) const { return of_[Index(seed)]; }
  size_t size() const { return of_.size(); }

 private:
  std::vector<std::vector<int>> of_;
};

// Seeds around a seed. For one thread.
class Surroundings {
 public:
  explicit Surroundings(const Neighbours& neighbours)
      : neighbours_(neighbours), seen_(neighbours.size(), -1) {}

  // The seed itself, then its neighbours, then theirs, and so on. Valid until the next call.
  const std::vector<int>& Within(int seed, int rings) {
    reached_.assign(1, seed);
    seen_[Index(seed)] = seed;
    size_t next = 0;
    for (int ring = 0; ring < rings; ++ring) {
      for (const size_t end = reached_.size(); next < end; ++next) {
        for (int neighbour : neighbours_.Of(reached_[next])) {
          if (seen_[Index(neighbour)] == seed) continue;
          seen_[Index(neighbour)] = seed;
          reached_.push_back(neighbour);
        }
      }
    }
    return reached_;
  }

 private:
  const Neighbours& neighbours_;
  std::vector<int> seen_;  // the last seed from which this one was reached
  std::vector<int> reached_;
};

// The value that a share of the others does not reach; 0 when there are none. Reorders them.
double Quantile(std::vector<double>& values, double share) {
  if (values.empty()) return 0;
  const auto rank = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size()));
  std::nth_element(values.begin(), values.begin() + rank, values.end());
  return values[static_cast<size_t>(rank)];
}

// Fits planes d(u, v) = x₀ + x₁·(u − u₀)/spacing + x₂·(v − v₀)/spacing around seeds.
class PlaneFitter {
 public:
  PlaneFitter(std::span<const Seed> seeds, const Neighbours& neighbours)
      : seeds_(seeds), neighbours_(neighbours), spacing_px_(Spacing()) {}

  // How far seeds lie from the planes through their neighbours alone.
  double EstimateNoise() const {
    std::vector<double> deviations;
    for (int i = 0; Index(i) < seeds_.size(); ++i) {
      constexpr size_t kEnough = 4;  // a plane takes three
      if (neighbours_.Of(i).size() < kEnough) continue;
      Eigen::Matrix3d normal = 1e-6 * Eigen::Matrix3d::Identity();
      Eigen::Vector3d right_side = Eigen::Vector3d::Zero();
      for (int j : neighbours_.Of(i)) Add(i, j, 1, normal, right_side);
      const auto solver = normal.ldlt();
      const double expected_px = solver.solve(right_side)[0];
      // The plane is uncertain as well: variance of its value here, in that of a seed.
      const double variance = solver.solve(Eigen::Vector3d::UnitX())[0];
      deviations.push_back(std::abs(seeds_[Index(i)].disparity() - expected_px) /
                           std::sqrt(1 + variance));
    }
    // A low quantile: curved surfaces and edges deviate as well, but not nearly all of the seeds.
    constexpr double kShare = 0.2;
    constexpr double kQuantileOfNormal = 0.2533;  // of the absolute value, in standard deviations
    return Quantile(deviations, kShare) / kQuantileOfNormal;
  }

  // @param support  of Surroundings.
  LocalPlane Fit(int seed, const std::vector<int>& support, double scale_px) const {
    const Seed& centre = seeds_[Index(seed)];
    Eigen::Vector3d x(centre.disparity(), 0, 0);
    for (int iteration = 0; iteration < kIterations; ++iteration) {
      // The first plane is level: a slant must not look like another surface.
      const double scale = iteration == 0 ? 2 * scale_px : scale_px;
      Eigen::Matrix3d normal = Eigen::Vector3d(1e-9, kSlopeHold, kSlopeHold).asDiagonal();
      Eigen::Vector3d right_side = Eigen::Vector3d::Zero();
      for (int i : support) {
        const double off = (seeds_[Index(i)].disparity() - Row(seed, i).dot(x)) / scale;
        const double weight = 1 / (1 + off * off);
        Add(seed, i, weight * weight, normal, right_side);
      }
      x = normal.ldlt().solve(right_side);
    }
    return {centre.u, centre.v, static_cast<float>(x[0]), static_cast<float>(x[1] / spacing_px_),
            static_cast<float>(x[2] / spacing_px_)};
  }

 private:
  // Median distance of neighbours.
  double Spacing() const {
    std::vector<double> distances;
    for (int i = 0; Index(i) < seeds_.size(); ++i) {
      for (int j : neighbours_.Of(i)) {
        const Seed& a = seeds_[Index(i)];
        const Seed& b = seeds_[Index(j)];
        distances.push_back(std::sqrt((double{a.u} - b.u) * (double{a.u} - b.u) +
                                      (double{a.v} - b.v) * (double{a.v} - b.v)));
      }
    }
    return distances.empty() ? 1 : Quantile(distances, 0.5);
  }

  Eigen::Vector3d Row(int centre, int seed) const {
    const Seed& from = seeds_[Index(centre)];
    const Seed& to = seeds_[Index(seed)];
    return {1, (double{to.u} - from.u) / spacing_px_, (double{to.v} - from.v) / spacing_px_};
  }

  void Add(int centre, int seed, double weight, Eigen::Matrix3d& normal,
           Eigen::Vector3d& right_side) const {
    const Eigen::Vector3d row = Row(centre, seed);
    normal += weight * row * row.transpose();
    right_side += weight * seeds_[Index(seed)].disparity() * row;
  }

  std::span<const Seed> seeds_;
  const Neighbours& neighbours_;
  double spacing_px_;
};

// For each seed, whether it is in a triangle whose disparities differ by at least `edge_px`.
std::vector<bool> SeedsAtEdges(std::span<const Seed> seeds, std::span<const SeedTriangle> triangles,
                               double edge_px) {
  std::vector<bool> at_edge(seeds.size());
  for (const SeedTriangle& triangle : triangles) {
    const auto disparity = [&](int corner) {
      return seeds[Index(triangle[Index(corner)])].disparity();
    };
    const auto [least, most] = std::minmax({disparity(0), disparity(1), disparity(2)});
    if (double{most} - least < edge_px) continue;
    for (int seed : triangle) at_edge[Index(seed)] = true;
  }
  return at_edge;
}

}  // namespace

SeedSurface FitSeedSurface(std::span<const Seed> seeds, std::span<const SeedTriangle> triangles,
                           double noisy_px, double edge_px) {
  const Neighbours neighbours(seeds.size(), triangles);
  const PlaneFitter fitter(seeds, neighbours);
  SeedSurface surface;
  surface.noise_px = fitter.EstimateNoise();
  const bool noisy = surface.noise_px > noisy_px;
  const double scale_px = std::max(kSmallestScalePx, 2 * surface.noise_px);
  surface.planes.resize(seeds.size());
  const std::vector<bool> at_edge = SeedsAtEdges(seeds, triangles, edge_px);
  cv::parallel_for_(
      {0, static_cast<int>(seeds.size())},
      [&](const cv::Range& range) {
        Surroundings surroundings(neighbours);
        for (int i = range.start; i < range.end; ++i) {
          const Seed& seed = seeds[Index(i)];
          LocalPlane plane{.u = seed.u, .v = seed.v, .disparity = seed.disparity()};
          if (noisy || at_edge[Index(i)]) {
            plane = fitter.Fit(i, surroundings.Within(i, noisy ? 2 : 1), scale_px);
          }
          if (!noisy) plane.disparity = seed.disparity();
          surface.planes[Index(i)] = plane;
        }
      },
      cv::getNumThreads());
  return surface;
}

}  // namespace sprout
