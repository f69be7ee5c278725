// Alg. 1 on a band of rows. Highway compiles this file once for each instruction set and picks one
// when the program runs; all of them compute in whole numbers, and in single operations of floating
// point that IEEE 754 defines to the last bit, so all give the same bytes.
#include <algorithm>
#include <cstdlib>

#include "services/grow/growth_band.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "services/grow/growth.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "services/grow/window_costs-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sprout {
namespace HWY_NAMESPACE {

struct Match {
  int disparity;
  int32_t cost;
};

// The best of three disparities; of equals d comes before d − 1 before d + 1. A cost and its place
// in that order make one number.
HWY_INLINE Match BestOf(Four costs, int d) {
  constexpr int kStep[] = {0, -1, 1, 0};
  const int32_t best = SmallestKey(costs, /*places of d + 1, d, d − 1, d − 2*/ {2, 0, 1, 3});
  return {d + kStep[best & 3], best >> 2};
}

template <GrowConfig::Similarity kSimilarity>
class Growth {
 public:
  Growth(const GrowthRule& rule, GrowthBand& band) : rule_(rule), band_(band), queue_(band.queue) {}

  // Alg. 1, step 2: similarity of every seed.
  void AddSeeds() {
    for (size_t i = 0; i < band_.seeds.size(); ++i) {
      GrowthSeed& seed = band_.seeds[i];
      const GrowthRow& row = band_.row(seed.v - band_.first_row());
      const auto costs = ToNumbers(FourCosts<kSimilarity>(rule_, row, seed.u, seed.disparity));
      queue_.Push(kInitial | static_cast<SeedQueue::Id>(i), costs[1], seed.next);
    }
  }

  void Run() {
    while (!queue_.empty()) {                       // Alg. 1, steps 4 and 13
      const Seed seed = TakeBest();                 // Step 5
      Visit(seed.row, seed.u - 1, seed.disparity);  // Step 6
      Visit(seed.row, seed.u + 1, seed.disparity);
      Visit(seed.row - 1, seed.u, seed.disparity);
      Visit(seed.row + 1, seed.u, seed.disparity);
    }
  }

  // One neighbour of a seed of disparity d.
  HWY_INLINE void Visit(int row_index, int u, int d) {
    const GrowthRow& row = band_.row(row_index);
    LeftPixel& pixel = row.left[u];
    if (pixel.disparity != LeftPixel::kFree || IsFarFromPrior(pixel, d)) return;
    const Match best = BestOf(FourCosts<kSimilarity>(rule_, row, u, d), d);
    if (best.cost > rule_.limit) return;  // Step 7
    uint8_t& right_matched = row.right_matched[u - best.disparity];
    if (right_matched != 0) return;                             // Step 8
    queue_.Push(PixelId(row_index, u), best.cost, pixel.next);  // Step 9
    pixel.disparity = static_cast<int16_t>(best.disparity);     // Step 10
    right_matched = 1;
    band_.changed = true;
  }

 private:
  // Seeds in the queue are pixels of the band (row, column) or initial ones (their number).
  static constexpr SeedQueue::Id kInitial = SeedQueue::Id{1} << 31;
  static SeedQueue::Id PixelId(int row, int u) { return static_cast<SeedQueue::Id>(row << 16 | u); }

  struct Seed {
    int row;
    int u;
    int disparity;
  };

  HWY_INLINE Seed TakeBest() {
    const SeedQueue::Id id = queue_.Top();
    if ((id & kInitial) != 0) {
      const GrowthSeed& seed = band_.seeds[id & ~kInitial];
      queue_.Pop(seed.next);
      return {seed.v - band_.first_row(), seed.u, seed.disparity};
    }
    const int row = static_cast<int>(id >> 16);
    const int u = static_cast<int>(id & 0xffff);
    const LeftPixel& pixel = band_.row(row).left[u];
    queue_.Pop(pixel.next);
    return {row, u, pixel.disparity};
  }

  // The prior alone rules out d − 1, d and d + 1.
  bool IsFarFromPrior(const LeftPixel& pixel, int d) const {
    constexpr int kOne = DisparityImage::kCountsPerPixel;
    return kSimilarity == GrowConfig::EPC &&
           std::abs(d * kOne - pixel.prior) > rule_.prior_reach + kOne;
  }

  const GrowthRule rule_;
  GrowthBand& band_;
  SeedQueue& queue_;
};

template <GrowConfig::Similarity kSimilarity>
void GrowSeeds(const GrowthRule& rule, GrowthBand& band) {
  Growth<kSimilarity> growth(rule, band);
  growth.AddSeeds();
  growth.Run();
}

template <GrowConfig::Similarity kSimilarity>
void GrowSeams(const GrowthRule& rule, SeamRow above, SeamRow below, GrowthBand& band) {
  Growth<kSimilarity> growth(rule, band);
  const auto cross = [&](SeamRow seam, int row) HWY_ATTR {
    for (size_t u = 0; u < seam.size(); ++u) {
      if (seam[u] > LeftPixel::kClosed) growth.Visit(row, static_cast<int>(u), seam[u]);
    }
  };
  cross(above, 0);
  cross(below, band.rows() - 1);
  growth.Run();
}

// Where between d − 1 and d + 1 the parabola through their costs has its minimum, from d, counts;
// none where a cost is missing or d is not the best of the three.
HWY_INLINE int SubPixelStep(const FourNumbers& costs) {
  const int32_t before = costs[2] - costs[1];
  const int32_t behind = costs[0] - costs[1];
  if (costs[0] == kExcludedCost || costs[2] == kExcludedCost || before < 0 || behind < 0 ||
      before + behind == 0) {
    return 0;
  }
  // Half a pixel times (before − behind) / (before + behind), rounded to nearest.
  constexpr float kHalf = DisparityImage::kCountsPerPixel / 2;
  const float step =
      kHalf * static_cast<float>(before - behind) / static_cast<float>(before + behind);
  return static_cast<int>(step + (kHalf + 0.5f)) - static_cast<int>(kHalf);
}

template <GrowConfig::Similarity kSimilarity>
void Write(const GrowthRule& rule, const GrowthBand& band, bool sub_pixel, DisparityImage& map) {
  constexpr int kOne = DisparityImage::kCountsPerPixel;
  for (int r = 0; r < band.rows(); ++r) {
    const GrowthRow& row = band.row(r);
    int16_t* counts = map.counts()[band.first_row() + r];
    for (int u = 0; u < band.width(); ++u) {
      const int d = row.left[u].disparity;
      if (d <= LeftPixel::kClosed) {
        counts[u] = DisparityImage::kInvalid;
        continue;
      }
      const int step =
          sub_pixel ? SubPixelStep(ToNumbers(FourCosts<kSimilarity>(rule, row, u, d))) : 0;
      counts[u] = static_cast<int16_t>(d * kOne + step);
    }
  }
}

void GrowFromSeedsOnTarget(const GrowthRule& rule, GrowthBand& band) {
  switch (rule.similarity) {
    case GrowConfig::MNCC:
      return GrowSeeds<GrowConfig::MNCC>(rule, band);
    case GrowConfig::EXPSSD:
      return GrowSeeds<GrowConfig::EXPSSD>(rule, band);
    case GrowConfig::EPC:
      return GrowSeeds<GrowConfig::EPC>(rule, band);
  }
}

void GrowFromSeamsOnTarget(const GrowthRule& rule, SeamRow above, SeamRow below, GrowthBand& band) {
  switch (rule.similarity) {
    case GrowConfig::MNCC:
      return GrowSeams<GrowConfig::MNCC>(rule, above, below, band);
    case GrowConfig::EXPSSD:
      return GrowSeams<GrowConfig::EXPSSD>(rule, above, below, band);
    case GrowConfig::EPC:
      return GrowSeams<GrowConfig::EPC>(rule, above, below, band);
  }
}

void WriteOnTarget(const GrowthRule& rule, const GrowthBand& band, bool sub_pixel,
                   DisparityImage& map) {
  switch (rule.similarity) {
    case GrowConfig::MNCC:
      return Write<GrowConfig::MNCC>(rule, band, sub_pixel, map);
    case GrowConfig::EXPSSD:
      return Write<GrowConfig::EXPSSD>(rule, band, sub_pixel, map);
    case GrowConfig::EPC:
      return Write<GrowConfig::EPC>(rule, band, sub_pixel, map);
  }
}

FourNumbers CostsOf(const GrowthRule& rule, const GrowthRow& row, int u, int d) {
  switch (rule.similarity) {
    case GrowConfig::MNCC:
      return ToNumbers(FourCosts<GrowConfig::MNCC>(rule, row, u, d));
    case GrowConfig::EXPSSD:
      return ToNumbers(FourCosts<GrowConfig::EXPSSD>(rule, row, u, d));
    case GrowConfig::EPC:
      break;
  }
  return ToNumbers(FourCosts<GrowConfig::EPC>(rule, row, u, d));
}

CostTriple CostsOnTarget(const GrowthRule& rule, const GrowthRow& row, int u, int d) {
  const FourNumbers costs = CostsOf(rule, row, u, d);
  return {costs[2], costs[1], costs[0]};
}

}  // namespace HWY_NAMESPACE
}  // namespace sprout
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sprout {

HWY_EXPORT(GrowFromSeedsOnTarget);
HWY_EXPORT(GrowFromSeamsOnTarget);
HWY_EXPORT(WriteOnTarget);
HWY_EXPORT(CostsOnTarget);

void GrowFromSeeds(const GrowthRule& rule, GrowthBand& band) {
  HWY_DYNAMIC_DISPATCH(GrowFromSeedsOnTarget)(rule, band);
}

void GrowFromSeams(const GrowthRule& rule, SeamRow above, SeamRow below, GrowthBand& band) {
  HWY_DYNAMIC_DISPATCH(GrowFromSeamsOnTarget)(rule, above, below, band);
}

void WriteBand(const GrowthRule& rule, const GrowthBand& band, bool sub_pixel,
               DisparityImage& map) {
  HWY_DYNAMIC_DISPATCH(WriteOnTarget)(rule, band, sub_pixel, map);
}

CostTriple CostsAt(const GrowthRule& rule, const GrowthBand& band, int u, int v, int d) {
  return HWY_DYNAMIC_DISPATCH(CostsOnTarget)(rule, band.row(v - band.first_row()), u, d);
}

}  // namespace sprout
#endif  // HWY_ONCE
