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

#include "services/grow/left_pixels-inl.h"
#include "services/grow/matches-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sprout {
namespace HWY_NAMESPACE {

// Seeds in the queue are pixels of the band or, with this bit, initial ones (number).
inline constexpr SeedQueue::Id kInitial = SeedQueue::Id{1} << 31;

template <class Matches>
class Growth {
 public:
  Growth(const Matches& matches, GrowthBand& band)
      : matches_(matches),
        band_(band),
        queue_(band.queue),
        left_(band.left.data()),
        right_matched_(band.right_matched.data()),
        stride_(static_cast<PixelId>(band.stride())) {}

  void Run() {
    while (!queue_.empty()) {                 // Alg. 1, steps 4 and 13
      const auto seed = TakeBest();           // Step 5
      Visit(seed.pixel - 1, seed.disparity);  // Step 6
      Visit(seed.pixel + 1, seed.disparity);
      Visit(seed.pixel - stride_, seed.disparity);
      Visit(seed.pixel + stride_, seed.disparity);
    }
  }

  // One neighbour of a seed of disparity d.
  HWY_INLINE void Visit(PixelId id, int d) {
    LeftPixel& pixel = left_[id];
    if (pixel.disparity != LeftPixel::kFree) return;
    const Match best = matches_.Best(id, pixel, d);
    if (best.level == kRefused) return;  // Step 7
    uint8_t& right_matched = right_matched_[static_cast<ptrdiff_t>(id) - best.disparity];
    if (right_matched != 0) return;                          // Step 8
    queue_.Push(id, best.level, pixel.next);                 // Step 9
    pixel.disparity = static_cast<int16_t>(best.disparity);  // Step 10
    right_matched = 1;
    band_.changed = true;
  }

 private:
  struct Seed {
    PixelId pixel;
    int disparity;
  };

  HWY_INLINE Seed TakeBest() {
    const SeedQueue::Id id = queue_.Top();
    if ((id & kInitial) != 0) {
      const GrowthSeed& seed = band_.seeds[id & ~kInitial];
      queue_.Pop(seed.next);
      return {band_.PixelAt(seed.v - band_.first_row(), seed.u), seed.disparity};
    }
    const LeftPixel& pixel = left_[id];
    queue_.Pop(pixel.next);
    return {id, pixel.disparity};
  }

  const Matches matches_;
  GrowthBand& band_;
  SeedQueue& queue_;
  LeftPixel* const left_;
  uint8_t* const right_matched_;
  const PixelId stride_;
};

// Alg. 1, step 2: similarity of every seed.
template <class Matches>
void AddSeeds(const Matches& matches, GrowthBand& band) {
  for (size_t i = 0; i < band.seeds.size(); ++i) {
    GrowthSeed& seed = band.seeds[i];
    const PixelId id = band.PixelAt(seed.v - band.first_row(), seed.u);
    const int level = matches.LevelOf(id, band.left[id], seed.disparity);
    band.queue.Push(kInitial | static_cast<SeedQueue::Id>(i), level, seed.next);
  }
}

template <class Matches>
void GrowSeams(const Matches& matches, SeamRow above, SeamRow below, GrowthBand& band) {
  Growth<Matches> growth(matches, band);
  const auto cross = [&](SeamRow seam, int row) HWY_ATTR {
    for (size_t u = 0; u < seam.size(); ++u) {
      if (seam[u] <= LeftPixel::kClosed) continue;
      growth.Visit(band.PixelAt(row, static_cast<int>(u)), seam[u]);
    }
  };
  cross(above, 0);
  cross(below, band.rows() - 1);
  growth.Run();
}

// Steps from the disparity of each pixel towards the least cost, where there are two candidates.
template <class D>
HWY_INLINE hn::Vec<D> StepsOfCandidates(const GrowthRow& row, int u, const LeftPixels<D>& pixels) {
  const D d;
  const hn::Rebind<int8_t, D> d8;
  const auto packed = hn::PromoteTo(d, hn::LoadU(d8, row.sub_pixel_steps + u));
  const auto better = hn::Add(hn::ShiftRight<5>(pixels.priors()), hn::And(packed, hn::Set(d, 1)));
  return hn::IfThenElseZero(hn::Eq(pixels.disparities(), better), hn::ShiftRight<1>(packed));
}

// Writes a row's counts, from whole disparities or the steps that are known of candidates.
HWY_INLINE void WriteRow(const GrowthRow& row, int width, int16_t* counts) {
  const auto sweep = [&](auto d, int u) HWY_ATTR {
    const hn::Rebind<int16_t, decltype(d)> d16;
    for (const int lanes = static_cast<int>(hn::MaxLanes(d)); u + lanes <= width; u += lanes) {
      const LeftPixels<decltype(d)> pixels(row.left + u);
      const auto disparities = pixels.disparities();
      auto values = hn::ShiftLeft<5>(disparities);
      if (row.sub_pixel_steps != nullptr) {
        values = hn::Add(values, StepsOfCandidates(row, u, pixels));
      }
      const auto matched = hn::Gt(disparities, hn::Set(d, LeftPixel::kClosed));
      values = hn::IfThenElse(matched, values, hn::Set(d, DisparityImage::kInvalid));
      hn::StoreU(hn::DemoteTo(d16, values), d16, counts + u);
    }
    return u;
  };
  const int rest = sweep(hn::CappedTag<int32_t, GrowthBand::kRunPixels>(), 0);
  sweep(hn::CappedTag<int32_t, 1>(), rest);
}

// Moves the counts of a row's matched pixels towards the least cost. @param least_open  only those
// of which the prior is no surer; 0: all.
template <GrowConfig::Similarity kSimilarity>
void RefineRow(const GrowthRule& rule, const GrowthRow& row, int least_open, int width,
               int16_t* counts) {
  const auto one = [](int32_t cost) HWY_ATTR { return hn::Set(hn::CappedTag<int32_t, 1>(), cost); };
  for (int u = 0; u < width; ++u) {
    if (counts[u] == DisparityImage::kInvalid || (least_open > 0 && row.sigma[u] < least_open)) {
      continue;
    }
    const int disparity = row.left[u].disparity;
    const auto costs = ToNumbers(FourCosts<kSimilarity>(rule, row, u, disparity));
    const auto step = StepsToMinimum(one(costs[2]), one(costs[1]), one(costs[0]));
    counts[u] =
        static_cast<int16_t>(disparity * DisparityImage::kCountsPerPixel + hn::GetLane(step));
  }
}

template <GrowConfig::Similarity kSimilarity>
void Write(const GrowthRule& rule, const GrowthBand& band, DisparityImage& map) {
  for (int r = 0; r < band.rows(); ++r) {
    int16_t* const counts = map.counts()[band.first_row() + r];
    WriteRow(band.row(r), band.width(), counts);
    if (!rule.sub_pixel || band.kind() == GrowthBand::Kind::kTabled) continue;
    const int least_open = band.kind() == GrowthBand::Kind::kMixed ? rule.least_open : 0;
    RefineRow<kSimilarity>(rule, band.row(r), least_open, band.width(), counts);
  }
}

template <class Matches>
void GrowSeeds(const Matches& matches, GrowthBand& band) {
  AddSeeds(matches, band);
  Growth(matches, band).Run();
}

void GrowFromSeedsOnTarget(const GrowthRule& rule, GrowthBand& band) {
  if (band.kind() == GrowthBand::Kind::kTabled) return GrowSeeds(TabledMatches(), band);
  if (band.kind() == GrowthBand::Kind::kMixed) return GrowSeeds(MixedMatches(rule, band), band);
  switch (rule.similarity) {
    case GrowConfig::MNCC:
      return GrowSeeds(ComputedMatches<GrowConfig::MNCC>(rule, band), band);
    case GrowConfig::EXPSSD:
      return GrowSeeds(ComputedMatches<GrowConfig::EXPSSD>(rule, band), band);
    case GrowConfig::EPC:
      return GrowSeeds(ComputedMatches<GrowConfig::EPC>(rule, band), band);
  }
}

void GrowFromSeamsOnTarget(const GrowthRule& rule, SeamRow above, SeamRow below, GrowthBand& band) {
  if (band.kind() == GrowthBand::Kind::kTabled) {
    return GrowSeams(TabledMatches(), above, below, band);
  }
  if (band.kind() == GrowthBand::Kind::kMixed) {
    return GrowSeams(MixedMatches(rule, band), above, below, band);
  }
  switch (rule.similarity) {
    case GrowConfig::MNCC:
      return GrowSeams(ComputedMatches<GrowConfig::MNCC>(rule, band), above, below, band);
    case GrowConfig::EXPSSD:
      return GrowSeams(ComputedMatches<GrowConfig::EXPSSD>(rule, band), above, below, band);
    case GrowConfig::EPC:
      return GrowSeams(ComputedMatches<GrowConfig::EPC>(rule, band), above, below, band);
  }
}

void WriteOnTarget(const GrowthRule& rule, const GrowthBand& band, DisparityImage& map) {
  switch (rule.similarity) {
    case GrowConfig::MNCC:
      return Write<GrowConfig::MNCC>(rule, band, map);
    case GrowConfig::EXPSSD:
      return Write<GrowConfig::EXPSSD>(rule, band, map);
    case GrowConfig::EPC:
      return Write<GrowConfig::EPC>(rule, band, map);
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

void WriteBand(const GrowthRule& rule, const GrowthBand& band, DisparityImage& map) {
  HWY_DYNAMIC_DISPATCH(WriteOnTarget)(rule, band, map);
}

CostTriple CostsAt(const GrowthRule& rule, const GrowthBand& band, int u, int v, int d) {
  return HWY_DYNAMIC_DISPATCH(CostsOnTarget)(rule, band.row(v - band.first_row()), u, d);
}

}  // namespace sprout
#endif  // HWY_ONCE
