// The candidates of all pixels of a band, for each instruction set: included by growth.cc, which
// Highway compiles once for each. No include guard of the usual kind for that reason.
#if defined(SPROUT_SERVICES_GROW_CANDIDATES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SPROUT_SERVICES_GROW_CANDIDATES_INL_H_
#undef SPROUT_SERVICES_GROW_CANDIDATES_INL_H_
#else
#define SPROUT_SERVICES_GROW_CANDIDATES_INL_H_
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <array>

#include "services/grow/growth_band.h"
#include "services/grow/left_pixels-inl.h"
#include "services/grow/window_costs-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sprout {
namespace HWY_NAMESPACE {

// Where between d − 1 and d + 1 the parabola through their costs has its minimum, from d, counts;
// none where a cost is missing or d is not the best of the three.
template <class V>
HWY_INLINE V StepsToMinimum(V minus_one, V cost, V plus_one) {
  const hn::DFromV<V> d;
  const hn::RebindToFloat<decltype(d)> df;
  const V before = hn::Sub(minus_one, cost);
  const V behind = hn::Sub(plus_one, cost);
  const V sum = hn::Add(before, behind);
  const auto missing = hn::Eq(hn::Max(minus_one, plus_one), hn::Set(d, kExcludedCost));
  const auto flat_or_not_best =
      hn::Lt(hn::Min(hn::Min(before, behind), hn::Sub(sum, hn::Set(d, 1))), hn::Zero(d));
  const auto none = hn::Or(missing, flat_or_not_best);
  // Half a pixel times (before − behind) / (before + behind), rounded to nearest.
  constexpr float kHalf = DisparityImage::kCountsPerPixel / 2;
  const auto difference = hn::IfThenZeroElse(none, hn::Sub(before, behind));
  const auto divisor = hn::Max(sum, hn::Set(d, 1));
  const auto step = hn::Div(hn::Mul(hn::Set(df, kHalf), hn::ConvertTo(df, difference)),
                            hn::ConvertTo(df, divisor));
  const V above_zero = hn::ConvertTo(d, hn::Add(step, hn::Set(df, kHalf + 0.5f)));
  return hn::Sub(above_zero, hn::Set(d, static_cast<int32_t>(kHalf)));
}

// Computes the candidates of as many neighbouring pixels of a row at once as a register has lanes.
// Neighbours need about the same disparities, and their windows share columns: for one disparity
// all the windows cost little more than two of them would alone.
template <bool kSubPixel>
class CandidateSweep {
 public:
  CandidateSweep(const GrowthRule& rule, GrowthBand& band) : rule_(rule), queue_(band.queue) {}

  // Replaces energies by candidates in the columns [begin, end).
  void Replace(const GrowthRow& row, int begin, int end) {
    for (int u = begin; u < end; u += kLanes) Replace(row, hn::Iota(D(), u), u, end);
  }

 private:
  using D = hn::CappedTag<int32_t, GrowthBand::kRunPixels>;
  using V = hn::Vec<D>;
  using M = hn::Mask<D>;
  static constexpr int kLanes = static_cast<int>(hn::MaxLanes(D()));

  // The disparities whose costs are needed: from m − kBefore on.
  static constexpr int kBefore = kSubPixel ? 1 : 0;
  static constexpr int kCosts = 2 + 2 * kBefore;

  // Sums over the right windows, and of the products with the left one, for each of these.
  struct Sums {
    V energy[kCosts];
    V cross[kCosts];
  };

  // A run of pixels from u on. Those behind `end` stay as they are.
  HWY_INLINE void Replace(const GrowthRow& row, V columns, int u, int end) {
    const D d;
    LeftPixels<D> pixels(row.left + u);
    const M inside = hn::Lt(columns, hn::Set(d, end));
    const M may_fit = hn::And(inside, MayFit(columns, pixels.priors()));
    const V candidates = Compute(row, u, pixels.energies(), pixels.priors(), may_fit);
    const M hopeless = hn::Lt(candidates, hn::Set(d, 1 << Candidates::kAccepted));
    pixels.Replace(inside, candidates,
                   hn::IfThenElse(hopeless, hn::Set(d, LeftPixel::kClosed), pixels.disparities()));
    pixels.Store(row.left + u);
  }

  // Of m − 1 to m + 2 one has a right window that lies in the image.
  static HWY_INLINE M MayFit(V columns, V prior) {
    const D d;
    const V first = hn::ShiftRight<5>(prior);
    return hn::And(hn::Gt(first, hn::Set(d, -2)),
                   hn::Gt(columns, hn::Add(first, hn::Set(d, kWindowRadius - 1))));
  }

  HWY_INLINE V Compute(const GrowthRow& row, int u, V left_energy, V prior, M may_fit) {
    const D d;
    const V first = hn::ShiftRight<5>(prior);
    const Sums sums = SumWindows(row, u, first, may_fit);
    const auto cost = [&](int i) HWY_ATTR {
      const V steps = hn::Set(d, i - kBefore);
      const V fraction = hn::And(prior, hn::Set(d, DisparityImage::kCountsPerPixel - 1));
      const V distance = hn::Sub(hn::ShiftLeft<5>(steps), fraction);
      const auto photo =
          PhotoCosts<GrowConfig::EPC>(rule_, hn::Add(left_energy, sums.energy[i]), sums.cross[i]);
      return WholeCosts(hn::Add(photo, PriorCosts(rule_, distance)), sums.energy[i],
                        hn::Add(first, steps));
    };
    const V best = cost(kBefore), next = cost(kBefore + 1);
    if constexpr (kSubPixel) {
      const V step = hn::And(StepsToMinimum(cost(0), best, next), hn::Set(d, 0xff));
      const V step_of_next = hn::And(StepsToMinimum(best, next, cost(3)), hn::Set(d, 0xff));
      const V steps = hn::Or(step, hn::ShiftLeft<8>(step_of_next));
      const hn::Rebind<uint16_t, D> d16;
      hn::StoreU(hn::DemoteTo(d16, steps), d16, row.sub_pixel_steps + u);
    }
    return Packed(best, next);
  }

  // Where none of the windows may fit energies are kOutside.
  static HWY_INLINE Sums SumWindows(const GrowthRow& row, int u, V first, M may_fit) {
    const D d;
    Sums sums;
    for (int i = 0; i < kCosts; ++i) {
      sums.energy[i] = hn::Set(d, GrowthBand::kOutside);
      sums.cross[i] = hn::Zero(d);
    }
    if (hn::AllFalse(d, may_fit)) return sums;
    constexpr int kNone = INT32_MAX;
    const V from = hn::IfThenElse(may_fit, hn::Sub(first, hn::Set(d, kBefore)), hn::Set(d, kNone));
    const auto least = [&](V disparities)
                           HWY_ATTR { return hn::GetLane(hn::MinOfLanes(d, disparities)); };
    const LeftRun<D> left(row, u);
    for (int disparity = least(from); disparity != kNone; ++disparity) {
      M needed = hn::Eq(from, hn::Set(d, disparity));
      for (int i = 1; i < kCosts; ++i) {
        needed = hn::Or(needed, hn::Eq(from, hn::Set(d, disparity - i)));
      }
      if (hn::AllFalse(d, needed)) {  // on to the next that a pixel needs
        const M later = hn::Gt(from, hn::Set(d, disparity));
        disparity = least(hn::IfThenElse(later, from, hn::Set(d, kNone)));
        if (disparity == kNone) break;
      }
      const V energy = hn::LoadU(d, row.right_energy + (u - disparity));
      const V cross = left.CrossSums(disparity);
      for (int i = 0; i < kCosts; ++i) {
        const M here = hn::Eq(from, hn::Set(d, disparity - i));
        sums.energy[i] = hn::IfThenElse(here, energy, sums.energy[i]);
        sums.cross[i] = hn::IfThenElse(here, cross, sums.cross[i]);
      }
    }
    return sums;
  }

  // As Candidates has them.
  HWY_INLINE V Packed(V cost, V cost_of_next) const {
    const D d;
    const V limit = hn::Set(d, rule_.limit);
    const auto bit = [&](auto mask, int place)
                         HWY_ATTR { return hn::IfThenElseZero(mask, hn::Set(d, 1 << place)); };
    // Near m − 1 only m is to choose from, near m + 2 only m + 1; of equals the one it is near to.
    const V better =
        hn::Or(hn::Or(bit(hn::Lt(cost_of_next, cost), Candidates::kBetter + 1),
                      bit(hn::Not(hn::Lt(cost, cost_of_next)), Candidates::kBetter + 2)),
               hn::Set(d, 1 << (Candidates::kBetter + 3)));
    const V accepted = hn::Or(bit(hn::Not(hn::Lt(limit, cost)), Candidates::kAccepted),
                              bit(hn::Not(hn::Lt(limit, cost_of_next)), Candidates::kAccepted + 1));
    return hn::Or(hn::Or(better, accepted),
                  hn::Or(Levels(cost), hn::ShiftLeft<8>(Levels(cost_of_next))));
  }

  // As SeedQueue::LevelOf().
  HWY_INLINE V Levels(V costs) const {
    const D d;
    const hn::RebindToFloat<D> df;
    const auto levels = hn::Mul(hn::ConvertTo(df, costs), hn::Set(df, queue_.levels_per_cost()));
    return hn::ConvertTo(d, hn::Min(levels, hn::Set(df, SeedQueue::kLevels - 1)));
  }

  const GrowthRule& rule_;
  const SeedQueue& queue_;
};

template <bool kSubPixel>
HWY_INLINE void TabulateRows(const GrowthRule& rule, GrowthBand& band) {
  CandidateSweep<kSubPixel> sweep(rule, band);
  for (int r = 0; r < band.rows(); ++r) {
    sweep.Replace(band.row(r), kWindowRadius, band.width() - kWindowRadius);
  }
}

// Replaces the energies of a band by the candidates of its pixels. Those that can have no match
// are closed.
HWY_INLINE void Tabulate(const GrowthRule& rule, GrowthBand& band) {
  return rule.sub_pixel ? TabulateRows<true>(rule, band) : TabulateRows<false>(rule, band);
}

}  // namespace HWY_NAMESPACE
}  // namespace sprout
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
