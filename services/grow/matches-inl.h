// The best match of a pixel near a disparity, for each instruction set: included by growth.cc,
// which Highway compiles once for each. No include guard of the usual kind for that reason.
#if defined(SPROUT_SERVICES_GROW_MATCHES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SPROUT_SERVICES_GROW_MATCHES_INL_H_
#undef SPROUT_SERVICES_GROW_MATCHES_INL_H_
#else
#define SPROUT_SERVICES_GROW_MATCHES_INL_H_
#endif

#include <cstdlib>

#include "services/grow/growth_band.h"
#include "services/grow/window_costs-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sprout {
namespace HWY_NAMESPACE {

// Level in the queue of seeds of what must not be matched: behind all levels.
inline constexpr int kRefused = SeedQueue::kLevels;

struct Match {
  int disparity;
  int level;
};

// The best of three disparities; of equals d comes before d − 1 before d + 1. A cost and its place
// in that order make one number.
HWY_INLINE Match BestOf(Four costs, int d, const GrowthRule& rule, const SeedQueue& queue) {
  constexpr int kStep[] = {0, -1, 1, 0};
  const int32_t best = SmallestKey(costs, /*places of d + 1, d, d − 1*/ {2, 0, 1});
  const int32_t cost = best >> 2;
  return {d + kStep[best & 3], cost <= rule.limit ? queue.LevelOf(cost) : kRefused};
}

// Matches whose costs are computed when a pixel is visited.
template <GrowConfig::Similarity kSimilarity>
class ComputedMatches {
 public:
  ComputedMatches(const GrowthRule& rule, const GrowthBand& band) : rule_(rule), band_(band) {}

  // Of d − 1, d, d + 1 at a free pixel.
  HWY_INLINE Match Best(PixelId id, const LeftPixel& pixel, int d) const {
    const GrowthRow& row = band_.row(band_.RowOf(id));
    const int u = band_.ColumnOf(id);
    if (IsFarFromPrior(row, u, pixel, d)) return {d, kRefused};
    const Four costs = FourCosts<kSimilarity>(rule_, row, u, d);
    return BestOf(costs, d, rule_, band_.queue);
  }

  // Of a seed of disparity d.
  HWY_INLINE int LevelOf(PixelId id, const LeftPixel&, int d) const {
    const GrowthRow& row = band_.row(band_.RowOf(id));
    return band_.queue.LevelOf(
        ToNumbers(FourCosts<kSimilarity>(rule_, row, band_.ColumnOf(id), d))[1]);
  }

 private:
  // The prior alone rules out d − 1, d and d + 1.
  bool IsFarFromPrior(const GrowthRow& row, int u, const LeftPixel& pixel, int d) const {
    constexpr int kOne = DisparityImage::kCountsPerPixel;
    return kSimilarity == GrowConfig::EPC &&
           std::abs(d * kOne - pixel.prior) > rule_.prior_reaches[row.sigma[u]] + kOne;
  }

  const GrowthRule& rule_;
  const GrowthBand& band_;
};

// The same, bit by bit, where only the two candidates of a pixel can be accepted: their costs have
// been computed before growth, in one sweep, which is several times faster than one by one.
class TabledMatches {
 public:
  HWY_INLINE Match Best(PixelId, const LeftPixel& pixel, int d) const {
    const int m = FirstCandidate(pixel);
    const auto near = static_cast<unsigned>(d - m + 1);
    if (near > 3) return {d, kRefused};
    const Candidates candidates = pixel.candidates;
    const unsigned which = candidates.Better(near);
    return {m + static_cast<int>(which),
            candidates.IsAccepted(which) ? candidates.Level(which) : kRefused};
  }

  HWY_INLINE int LevelOf(PixelId, const LeftPixel& pixel, int d) const {
    const auto which = static_cast<unsigned>(d - FirstCandidate(pixel));
    return which < 2 ? pixel.candidates.Level(which) : SeedQueue::kLevels - 1;
  }
};

// Each pixel as its prior has it.
class MixedMatches {
 public:
  MixedMatches(const GrowthRule& rule, const GrowthBand& band) : computed_(rule, band) {}

  HWY_INLINE Match Best(PixelId id, const LeftPixel& pixel, int d) const {
    return pixel.candidates.IsOpen() ? computed_.Best(id, pixel, d) : tabled_.Best(id, pixel, d);
  }

  HWY_INLINE int LevelOf(PixelId id, const LeftPixel& pixel, int d) const {
    return pixel.candidates.IsOpen() ? computed_.LevelOf(id, pixel, d)
                                     : tabled_.LevelOf(id, pixel, d);
  }

 private:
  ComputedMatches<GrowConfig::EPC> computed_;
  TabledMatches tabled_;
};

}  // namespace HWY_NAMESPACE
}  // namespace sprout
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
