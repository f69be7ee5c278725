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

#include "services/grow/candidates-inl.h"
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
template <GrowConfig::Similarity kSimilarity>
void AddSeeds(const GrowthRule& rule, GrowthBand& band) {
  for (size_t i = 0; i < band.seeds.size(); ++i) {
    GrowthSeed& seed = band.seeds[i];
    const GrowthRow& row = band.row(seed.v - band.first_row());
    const auto costs = ToNumbers(FourCosts<kSimilarity>(rule, row, seed.u, seed.disparity));
    band.queue.Push(kInitial | static_cast<SeedQueue::Id>(i), band.queue.LevelOf(costs[1]),
                    seed.next);
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
template <class V>
HWY_INLINE V StepsOfCandidates(const GrowthRow& row, int u, V priors, V disparities) {
  const hn::DFromV<V> d;
  const hn::Rebind<uint16_t, decltype(d)> d16;
  const V both = hn::PromoteTo(d, hn::LoadU(d16, row.sub_pixel_steps + u));
  const auto is_first = hn::Eq(disparities, hn::ShiftRight<5>(priors));
  const V above = hn::IfThenElse(is_first, hn::ShiftLeft<8>(both), both);
  return hn::ShiftRight<24>(hn::ShiftLeft<16>(above));
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
        values = hn::Add(values, StepsOfCandidates(row, u, pixels.priors(), disparities));
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

// Moves the counts of a row's matched pixels towards the least cost.
template <GrowConfig::Similarity kSimilarity>
void RefineRow(const GrowthRule& rule, const GrowthRow& row, int width, int16_t* counts) {
  const auto one = [](int32_t cost) HWY_ATTR { return hn::Set(hn::CappedTag<int32_t, 1>(), cost); };
  for (int u = 0; u < width; ++u) {
    if (counts[u] == DisparityImage::kInvalid) continue;
    const auto costs = ToNumbers(FourCosts<kSimilarity>(rule, row, u, row.left[u].disparity));
    const auto step = StepsToMinimum(one(costs[2]), one(costs[1]), one(costs[0]));
    counts[u] = static_cast<int16_t>(counts[u] + hn::GetLane(step));
  }
}

template <GrowConfig::Similarity kSimilarity>
void Write(const GrowthRule& rule, const GrowthBand& band, DisparityImage& map) {
  for (int r = 0; r < band.rows(); ++r) {
    int16_t* const counts = map.counts()[band.first_row() + r];
    WriteRow(band.row(r), band.width(), counts);
    if (rule.sub_pixel && !rule.two_candidates()) {
      RefineRow<kSimilarity>(rule, band.row(r), band.width(), counts);
    }
  }
}

template <GrowConfig::Similarity kSimilarity>
void GrowSeeds(const GrowthRule& rule, GrowthBand& band) {
  AddSeeds<kSimilarity>(rule, band);
  if (rule.two_candidates()) {
    Tabulate(rule, band);
    return Growth(TabledMatches(), band).Run();
  }
  Growth(ComputedMatches<kSimilarity>(rule, band), band).Run();
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
  if (rule.two_candidates()) return GrowSeams(TabledMatches(), above, below, band);
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
