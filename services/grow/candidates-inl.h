// The candidates of the pixels of a row, for each instruction set: included by growth_tables.cc,
// which Highway compiles once for each. No include guard of the usual kind for that reason.
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

// Computes the candidates of as many neighbouring pixels of a row at once as a register has lanes.
// Neighbours need about the same disparities, and their windows share columns: for one disparity
// all the windows cost little more than two of them would alone.
template <bool kSubPixel>
class CandidateSweep {
 public:
  CandidateSweep(const GrowthRule& rule, const SeedQueue& queue) : rule_(rule), queue_(queue) {}

  // Fills the pixels in the columns [begin, end). Those that can have no match are closed.
  // @param priors  of the row's pixels; kRunPixels more can be read.
  void Fill(const GrowthRow& row, const int16_t* priors, int begin, int end) const {
    const D d;
    const hn::Rebind<int16_t, D> d16;
    for (int u = begin; u < end; u += kLanes) {
      const V prior = hn::PromoteTo(d, hn::LoadU(d16, priors + u));
      const M inside = hn::Lt(hn::Iota(d, u), hn::Set(d, end));
      const V candidates = Compute(row, u, hn::LoadU(d, row.left_energy + u), prior, inside);
      const M hopeless = hn::Lt(candidates, hn::Set(d, 1 << Candidates::kAccepted));
      LeftPixels<D> pixels(
          candidates, prior,
          hn::IfThenElse(hopeless, hn::Set(d, LeftPixel::kClosed), hn::Set(d, LeftPixel::kFree)));
      if (u + kLanes > end) pixels.ReplaceUnless(inside, LeftPixels<D>(row.left + u));
      pixels.Store(row.left + u);
    }
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

  // Of m − 1 to m + 2 one has a right window that lies in the image.
  static HWY_INLINE M MayFit(V columns, V first) {
    const D d;
    return hn::And(hn::Gt(first, hn::Set(d, -2)),
                   hn::Gt(columns, hn::Add(first, hn::Set(d, kWindowRadius - 1))));
  }

  // Those of the pixels from u on.
  HWY_INLINE V Compute(const GrowthRow& row, int u, V left_energy, V prior, M inside) const {
    const D d;
    const V first = hn::ShiftRight<5>(prior);
    const Sums sums = SumWindows(row, u, first, hn::And(inside, MayFit(hn::Iota(d, u), first)));
    const auto cost_at = [&](V steps, V energy, V cross) HWY_ATTR {
      const V fraction = hn::And(prior, hn::Set(d, DisparityImage::kCountsPerPixel - 1));
      const V distance = hn::Sub(hn::ShiftLeft<5>(steps), fraction);
      const auto photo = PhotoCosts<GrowConfig::EPC>(rule_, hn::Add(left_energy, energy), cross);
      return WholeCosts(hn::Add(photo, PriorCosts(rule_.prior_scales[0], distance)), energy,
                        hn::Add(first, steps));
    };
    const V cost = cost_at(hn::Zero(d), sums.energy[kBefore], sums.cross[kBefore]);
    const V cost_of_next =
        cost_at(hn::Set(d, 1), sums.energy[kBefore + 1], sums.cross[kBefore + 1]);
    if constexpr (kSubPixel) {  // of the better one: the other is not the least of its three
      const M next_is_better = hn::Lt(cost_of_next, cost);
      const auto choose = [&](V if_next, V if_not)
                              HWY_ATTR { return hn::IfThenElse(next_is_better, if_next, if_not); };
      const V beyond =
          cost_at(choose(hn::Set(d, 2), hn::Set(d, -1)), choose(sums.energy[3], sums.energy[0]),
                  choose(sums.cross[3], sums.cross[0]));
      const V steps = StepsToMinimum(choose(cost, beyond), hn::Min(cost, cost_of_next),
                                     choose(beyond, cost_of_next));
      const V packed =
          hn::Or(hn::ShiftLeft<1>(steps), hn::IfThenElseZero(next_is_better, hn::Set(d, 1)));
      const hn::Rebind<int8_t, D> d8;
      hn::StoreU(hn::DemoteTo(d8, packed), d8, row.sub_pixel_steps + u);
    }
    return Packed(cost, cost_of_next);
  }

  // Where none of the windows may fit energies are kOutside.
  static HWY_INLINE Sums SumWindows(const GrowthRow& row, int u, V first, M may_fit) {
    const D d;
    Sums sums;
    HWY_UNROLL(4)
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
      HWY_UNROLL(4)
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
      HWY_UNROLL(4)
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
    const V in_range = hn::Min(costs, hn::Set(d, rule_.limit));
    return hn::ShiftRight<SeedQueue::kLevelFraction>(
        hn::Mul(in_range, hn::Set(d, queue_.levels_per_cost())));
  }

  const GrowthRule& rule_;
  const SeedQueue& queue_;
};

}  // namespace HWY_NAMESPACE
}  // namespace sprout
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
