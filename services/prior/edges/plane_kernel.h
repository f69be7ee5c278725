#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "common/core/seed.h"
#include "services/prior/edges/seed_planes.h"

namespace sprout::prior {

/// Seeds whose planes are fitted at once, one a lane, and what they are fitted to.
struct PlaneFits {
  static constexpr int kAtOnce = 8;
  static constexpr size_t kMaxSupport = 64;
  using Numbers = std::array<double, kAtOnce>;

  /// Level at the seeds, before; what is fitted, afterwards.
  std::array<Plane, kAtOnce> planes;
  Numbers scale_px;  ///< s of eq. (P1)
  Numbers near_px;   ///< q of eq. (P3); 0: the disparity is that of the plane

  /// The seeds around: positions from the lane's own one, px, disparities, and the weights of eq.
  /// (P1) by their standard deviations. Those with no weight fill up shorter lists.
  std::array<Numbers, kMaxSupport> across, down, disparity, weight;
  size_t most_support = 0;

  /// @param support  kMaxSupport at most.
  void SetSupport(size_t lane, std::span<const Seed> seeds, std::span<const int> support) {
    const Plane& plane = planes[lane];
    for (size_t j = 0; j < support.size(); ++j) {
      if (j >= most_support) StartRow(j);
      const Seed& seed = seeds[static_cast<size_t>(support[j])];
      across[j][lane] = double{seed.u} - plane.u;
      down[j][lane] = double{seed.v} - plane.v;
      disparity[j][lane] = seed.disparity();
      weight[j][lane] = SureWeight(plane.sigma_px, seed.sigma_px);
    }
  }

 private:
  // How much less a seed counts that is less sure than the one whose plane it is. What lies below
  // σ₀ is not told apart.
  static double SureWeight(double sigma_px, double other_sigma_px) {
    constexpr double kSurePx = 0.1;
    return (kSurePx * kSurePx + sigma_px * sigma_px) /
           (kSurePx * kSurePx + other_sigma_px * other_sigma_px);
  }

  void StartRow(size_t j) {
    across[j] = down[j] = disparity[j] = weight[j] = {};
    most_support = j + 1;
  }
};

/// Eqs. (P1) and (P3) of the README, by iteratively reweighted least squares. The same on every
/// CPU.
void FitPlanesAtOnce(double slope_weight, PlaneFits& fits);

}  // namespace sprout::prior
