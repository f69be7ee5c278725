#ifndef SPROUT_SERVICES_TOOLS_EVALUATE_SEED_QUALITY_H_
#define SPROUT_SERVICES_TOOLS_EVALUATE_SEED_QUALITY_H_

#include <cstdint>
#include <span>

#include "common/config/config.h"
#include "common/core/seed.h"
#include "services/tools/evaluate/scene.h"

namespace sprout::evaluate {

/// Error above which a seed is wrong, px.
inline constexpr double kWrongSeedPx = 3;

/// Counts of seeds, judged by the ground truth at their nearest pixel of the left image.
struct SeedCounts {
  /// At most kWrongSeedPx from the truth, on a pixel that both cameras see (NonOccludedMask()).
  int64_t good = 0;
  /// Seeds that are more than kWrongSeedPx from the truth, or on a pixel that a nearer surface
  /// hides from the right camera (OccludedMask()).
  int64_t wrong = 0;
  // Others cannot be judged: beyond the border of an image, or truth unknown.
};

/// O(n).
SeedCounts CountSeeds(std::span<const Seed> seeds, const Scene& scene);

/// How many good ToF points have no seed any more. Stereo seeds do not replace them, and a point
/// that refinement moved is not lost.
/// @param points  all ToF points. @param kept  the seeds after refinement. O(n log n).
int64_t CountGoodLost(std::span<const Seed> points, std::span<const Seed> kept, const Scene& scene);

/// Effect of refinement on the seeds of a scene, without added noise.
struct RefinementQuality {
  SeedSet refined;        ///< the seeds kept, and how many points each rule dropped
  SeedCounts before;      ///< of all ToF points
  SeedCounts after;       ///< of the seeds kept and those from stereo
  int64_t good_lost = 0;  ///< CountGoodLost()

  double wrong_before_percent() const;  ///< wrong ones among all ToF points
  double wrong_after_percent() const;   ///< wrong ones among the seeds kept and those from stereo
  double good_lost_percent() const;     ///< share of the good ToF points that was dropped
};

/// Runs refinement on a scene and evaluates it. Shares with denominator 0 are NaN.
RefinementQuality JudgeRefinement(const Scene& scene, const RefineConfig& config);

}  // namespace sprout::evaluate

#endif  // SPROUT_SERVICES_TOOLS_EVALUATE_SEED_QUALITY_H_
