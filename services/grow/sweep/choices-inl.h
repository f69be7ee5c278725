// What each pixel of a row chooses, for each instruction set: included by sweep_kernel.cc, which
// Highway compiles once for each, so it has no usual include guard.
#if defined(SPROUT_SERVICES_GROW_CHOICES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SPROUT_SERVICES_GROW_CHOICES_INL_H_
#undef SPROUT_SERVICES_GROW_CHOICES_INL_H_
#else
#define SPROUT_SERVICES_GROW_CHOICES_INL_H_
#endif

#include <hwy/highway.h>

#include "services/grow/sweep/sweep_band.h"
#include "services/grow/sweep/window_runs-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sprout::grow {
namespace HWY_NAMESPACE {

// Neighbouring pixels, and the best disparity of each so far. Disparities are tried in rising order
// for all of them at once, from the lowest that one needs to the highest.
template <bool kSubPixel>
class WideChoice {
 public:
  using D = RunTag;
  using V = hn::Vec<D>;
  using M = hn::Mask<D>;

  // @param u  the first pixel. @param wanted  pixels whose result is used.
  HWY_INLINE WideChoice(const GrowthRule& rule, const ChoiceInput& row, int u, V prior, V sigma,
                        M wanted)
      : rule_(rule), row_(row), u_(u), prior_(prior), left_(row.left, u) {
    const D d;
    scale_ = hn::GatherIndex(DF(), rule.prior_scales.data(), sigma);
    const V reach = hn::GatherIndex(d, rule.prior_reaches.data(), sigma);
    static_assert(DisparityImage::kCountsPerPixel == 1 << 5);
    const V lowest = hn::ShiftRight<5>(
        hn::Add(hn::Sub(prior, reach), hn::Set(d, DisparityImage::kCountsPerPixel - 1)));
    const V highest = hn::ShiftRight<5>(hn::Add(prior, reach));
    room_ = HighestThatFits(hn::Iota(d, u));
    lowest_ = hn::IfThenElse(wanted, hn::Max(lowest, hn::Zero(d)), hn::Set(d, kNever));
    highest_ = hn::IfThenElse(wanted, hn::Min(highest, room_), hn::Set(d, -kNever));
    left_energy_ = hn::LoadU(d, row.left_energies + u);
    best_.cost = hn::Set(d, kExcludedCost);
    best_.disparity = hn::Set(d, -kNever);
    cost_before_ = cost_behind_ = last_cost_ = best_.cost;
    best_.step = hn::Zero(d);
    difference_ = difference_before_ = difference_behind_ = last_difference_ = hn::Zero(DF());
    energy_ = hn::Set(DF(), 1.0F);
  }

  HWY_INLINE ChoiceOf<V> Best() {
    const D d;
    const V from = hn::Sub(lowest_, hn::Set(d, kBeside));
    const V to = hn::Add(highest_, hn::Set(d, kBeside));
    const int end = hn::GetLane(hn::MaxOfLanes(d, to));
    for (int disparity = hn::GetLane(hn::MinOfLanes(d, from)); disparity <= end; ++disparity) {
      const V here = hn::Set(d, disparity);
      if (hn::AllTrue(d, hn::Or(hn::Gt(from, here), hn::Gt(here, to)))) {
        const V later = hn::IfThenElse(hn::Gt(from, here), from, hn::Set(d, kNever));
        disparity = hn::GetLane(hn::MinOfLanes(d, later)) - 1;  // on to the next that one needs
        continue;
      }
      Try(disparity);
    }
    if constexpr (kSubPixel) best_.step = Step();
    return best_;
  }

 private:
  using DF = hn::RebindToFloat<D>;
  using F = hn::Vec<DF>;
  static constexpr int kBeside = kSubPixel ? 1 : 0;  // disparities around the best that are needed
  static constexpr int kNever = 1 << 20;

  HWY_INLINE void Try(int disparity) {
    const D d;
    const ptrdiff_t right = ptrdiff_t{u_} - disparity;
    const V energy = hn::Add(left_energy_, hn::LoadU(d, row_.right_energies + right));
    const V cross = left_.Products(row_.right, right);
    const F difference = hn::ConvertTo(DF(), hn::Sub(hn::Sub(energy, cross), cross));
    const V here = hn::Set(d, disparity);
    const F distance = hn::ConvertTo(DF(), hn::Sub(hn::ShiftLeft<5>(here), prior_));
    const F energies = AtLeastOne(energy);
    const V cost =
        EpcCosts(rule_, energies, difference, distance, scale_, hn::Or(here, hn::Sub(room_, here)));
    if constexpr (kSubPixel) {
      const M follows = hn::Eq(best_.disparity, hn::Set(d, disparity - 1));
      cost_behind_ = hn::IfThenElse(follows, cost, cost_behind_);
      difference_behind_ = Choose(follows, difference, difference_behind_);
    }
    const M is_better = hn::Lt(cost, best_.cost);
    best_.cost = hn::Min(cost, best_.cost);
    best_.disparity = hn::IfThenElse(is_better, here, best_.disparity);
    if constexpr (kSubPixel) {
      cost_before_ = hn::IfThenElse(is_better, last_cost_, cost_before_);
      difference_before_ = Choose(is_better, last_difference_, difference_before_);
      best_.step = hn::Zero(d);
      difference_ = Choose(is_better, difference, difference_);
      energy_ = Choose(is_better, energies, energy_);
      last_cost_ = cost;
      last_difference_ = difference;
    }
  }

  HWY_INLINE F Choose(M mask, F yes, F no) const {
    return hn::IfThenElse(hn::RebindMask(DF(), mask), yes, no);
  }

  // (S2)
  HWY_INLINE V Step() const {
    const D d;
    const F distance = hn::ConvertTo(DF(), hn::Sub(hn::ShiftLeft<5>(best_.disparity), prior_));
    return StepsToMinimum(
        rule_,
        StepWindows<F, V>{difference_before_, difference_, difference_behind_, cost_before_,
                          best_.cost, cost_behind_, hn::LoadU(d, row_.left_textures + u_),
                          hn::LoadU(d, row_.left_textures + u_ + 1), energy_, distance},
        scale_);
  }

  const GrowthRule& rule_;
  const ChoiceInput& row_;
  const int u_;
  const V prior_;
  const WindowRun<D> left_;
  F scale_;
  V lowest_, highest_, room_, left_energy_;
  ChoiceOf<V> best_;
  V cost_before_, cost_behind_, last_cost_;
  F difference_, difference_before_, difference_behind_, last_difference_, energy_;
};

// Where the choices of a row go; written up to kRunPixels behind the row's end.
struct ChoiceRow {
  static constexpr int16_t kNone = -(1 << 14);  // no choice; far from all disparities
  static constexpr int16_t kNoKey = INT16_MAX;  // of a pixel without a choice

  int16_t* disparities;  // px
  int16_t* keys;         // of the costs, even: twice GrowthRule::KeyOf()
  int8_t* steps;         // counts from the disparity to the least cost; only with sub_pixel
};

// Chooses for the pixels of a row, as many neighbours at once as a register has lanes. Neighbours
// need about the same disparities, and their windows share columns: for one disparity all the
// windows cost little more than two of them would alone.
// @tparam kWide  whether there may be pixels with more than two candidates.
template <bool kSubPixel, bool kWide>
class Choice {
 public:
  Choice(const GrowthRule& rule, const ChoiceInput& row)
      : rule_(rule), row_(row), right_(row.right), right_energies_(row.right_energies) {}

  // Open pixels have no choice. @returns whether there is one.
  bool Run(int width, const ChoiceRow& to) const {
    const D d;
    const hn::Rebind<int16_t, D> d16;
    const hn::Rebind<uint8_t, D> d8;
    const hn::Rebind<int8_t, D> d8_signed;
    M any_open = hn::FirstN(d, 0);
    for (int u = kWindowRadius; u < width - kWindowRadius; u += kLanes) {
      const V prior = hn::PromoteTo(d, hn::LoadU(d16, row_.priors + u));
      const V sigma = hn::PromoteTo(d, hn::LoadU(d8, row_.sigmas + u));
      const M inside = hn::AndNot(hn::Eq(prior, hn::Set(d, DisparityImage::kInvalid)),
                                  hn::Lt(hn::Iota(d, u), hn::Set(d, width - kWindowRadius)));
      const M open = hn::And(inside, hn::Gt(sigma, hn::Set(d, rule_.min_open_sigma - 1)));
      any_open = hn::Or(any_open, open);
      const M swept = hn::AndNot(open, inside);
      const Best best = BestOf(u, prior, sigma, swept);
      const M accepted = hn::AndNot(hn::Gt(best.cost, hn::Set(d, rule_.limit)), swept);
      const V key = hn::ShiftLeft<1>(hn::ShiftRightSame(best.cost, rule_.key_shift));
      hn::StoreU(
          hn::DemoteTo(d16, hn::IfThenElse(accepted, best.disparity, hn::Set(d, ChoiceRow::kNone))),
          d16, to.disparities + u);
      hn::StoreU(hn::DemoteTo(d16, hn::IfThenElse(accepted, key, hn::Set(d, ChoiceRow::kNoKey))),
                 d16, to.keys + u);
      if constexpr (kSubPixel) {
        hn::StoreU(hn::DemoteTo(d8_signed, best.step), d8_signed, to.steps + u);
      }
    }
    // At the last pixel the next one has no window.
    if (kSubPixel && width > 2 * kWindowRadius) to.steps[width - kWindowRadius - 1] = 0;
    return !hn::AllFalse(d, any_open);
  }

 private:
  using D = RunTag;
  using V = hn::Vec<D>;
  using M = hn::Mask<D>;
  using Best = ChoiceOf<V>;
  static constexpr int kLanes = static_cast<int>(hn::MaxLanes(D()));

  // The disparities whose costs are needed: from m − kBefore on.
  static constexpr int kBefore = kSubPixel ? 1 : 0;
  static constexpr int kCosts = 2 + 2 * kBefore;

  using F = hn::Vec<hn::RebindToFloat<D>>;

  // Sums over the right windows, and of the products with the left one, for each of these.
  struct Sums {
    V energy[kCosts];
    V cross[kCosts];
  };

  // Whether the right window of one of the disparities m − 1 to m + 2 lies in the image.
  static HWY_INLINE M MayFit(V columns, V first) {
    const D d;
    return hn::And(hn::Gt(first, hn::Set(d, -2)),
                   hn::Gt(columns, hn::Add(first, hn::Set(d, kWindowRadius - 1))));
  }

  // @param wanted  pixels whose result is used; the results of the others do not matter.
  HWY_INLINE Best BestOf(int u, V prior, V sigma, M wanted) const {
    const D d;
    if constexpr (!kWide) return BestOfTwo(u, prior, wanted);
    const M is_wide = hn::And(wanted, hn::Gt(sigma, hn::Set(d, rule_.min_wide_sigma - 1)));
    if (hn::AllFalse(d, is_wide)) return BestOfTwo(u, prior, wanted);
    const Best of_all = BestOfAll(u, prior, sigma, is_wide);
    const M is_sure = hn::AndNot(is_wide, wanted);
    if (hn::AllFalse(d, is_sure)) return of_all;
    const Best of_two = BestOfTwo(u, prior, is_sure);
    const auto choose = [&](V if_wide, V if_not)
                            HWY_ATTR { return hn::IfThenElse(is_wide, if_wide, if_not); };
    return {choose(of_all.disparity, of_two.disparity), choose(of_all.cost, of_two.cost),
            choose(of_all.step, of_two.step)};
  }

  // A function of its own, so that few registers are taken where pixels have two candidates.
  HWY_NOINLINE Best BestOfAll(int u, V prior, V sigma, M wanted) const {
    return WideChoice<kSubPixel>(rule_, row_, u, prior, sigma, wanted).Best();
  }

  // The better of the disparities m and m + 1 at the pixels from u on. @param wanted  pixels whose
  // result is used; the results of the others do not matter.
  HWY_INLINE Best BestOfTwo(int u, V prior, M wanted) const {
    const D d;
    const V columns = hn::Iota(d, u);
    const V first = hn::ShiftRight<5>(prior);
    const WindowRun<D> left(row_.left, u);
    const V left_energy = hn::LoadU(d, row_.left_energies + u);
    const Sums sums = SumWindows(left, u, first, hn::And(wanted, MayFit(columns, first)));
    const hn::RebindToFloat<D> df;
    V energy[kCosts];      // Σ(wL² + wR²)
    F difference[kCosts];  // Σ(wL − wR)²
    HWY_UNROLL(4)
    for (int i = 0; i < kCosts; ++i) {
      energy[i] = hn::Add(left_energy, sums.energy[i]);
      difference[i] = hn::ConvertTo(df, hn::Sub(hn::Sub(energy[i], sums.cross[i]), sums.cross[i]));
    }
    // Distances from m to D_p, and from D_p to m + 1, counts.
    const F fraction =
        hn::ConvertTo(df, hn::And(prior, hn::Set(d, DisparityImage::kCountsPerPixel - 1)));
    const F rest = hn::Sub(hn::Set(df, DisparityImage::kCountsPerPixel), fraction);
    const V room = hn::Sub(HighestThatFits(columns), first);
    const auto cost_at = [&](V steps, F energies, F differences, F distances) HWY_ATTR {
      const V fits = hn::Or(hn::Add(first, steps), hn::Sub(room, steps));
      return EpcCosts(rule_, energies, differences, distances, hn::Set(df, rule_.prior_scales[0]),
                      fits);
    };
    const F energy_of_m = AtLeastOne(energy[kBefore]);
    const F energy_of_next = AtLeastOne(energy[kBefore + 1]);
    const V cost = cost_at(hn::Zero(d), energy_of_m, difference[kBefore], fraction);
    const V cost_of_next = cost_at(hn::Set(d, 1), energy_of_next, difference[kBefore + 1], rest);
    const M next_is_better = hn::Lt(cost_of_next, cost);
    const auto choose = [&](V if_next, V if_not)
                            HWY_ATTR { return hn::IfThenElse(next_is_better, if_next, if_not); };
    Best best{choose(hn::Add(first, hn::Set(d, 1)), first), hn::Min(cost, cost_of_next),
              hn::Zero(d)};
    if constexpr (kSubPixel) {
      const auto next = hn::RebindMask(df, next_is_better);
      const auto one_of = [&](F if_next, F if_not)
                              HWY_ATTR { return hn::IfThenElse(next, if_next, if_not); };
      const F distance = one_of(rest, fraction);
      const F beyond_distance = hn::Add(distance, hn::Set(df, DisparityImage::kCountsPerPixel));
      const F beyond_difference = one_of(difference[3], difference[0]);
      const F own_difference = one_of(difference[2], difference[1]);
      const F other_difference = one_of(difference[1], difference[2]);
      const V beyond =
          cost_at(choose(hn::Set(d, 2), hn::Set(d, -1)), AtLeastOne(choose(energy[3], energy[0])),
                  beyond_difference, beyond_distance);
      best.step = StepsToMinimum(
          rule_,
          StepWindows<F, V>{one_of(other_difference, beyond_difference), own_difference,
                            one_of(beyond_difference, other_difference),
                            hn::Max(cost, cost_of_next), best.cost, beyond,
                            hn::LoadU(d, row_.left_textures + u),
                            hn::LoadU(d, row_.left_textures + u + 1),
                            one_of(energy_of_next, energy_of_m), one_of(rest, hn::Neg(fraction))},
          hn::Set(df, rule_.prior_scales[0]));
    }
    return best;
  }

  HWY_INLINE Sums SumWindows(const WindowRun<D>& left, int u, V first, M may_fit) const {
    const D d;
    Sums sums;
    HWY_UNROLL(4)
    for (int i = 0; i < kCosts; ++i) {
      sums.energy[i] = hn::Zero(d);
      sums.cross[i] = hn::Zero(d);
    }
    if (hn::AllFalse(d, may_fit)) return sums;
    constexpr int kNone = INT32_MAX;
    const V from = hn::IfThenElse(may_fit, hn::Sub(first, hn::Set(d, kBefore)), hn::Set(d, kNone));
    const auto least = [&](V disparities)
                           HWY_ATTR { return hn::GetLane(hn::MinOfLanes(d, disparities)); };
    const int lowest = least(from);
    const ptrdiff_t first_right = ptrdiff_t{u} - lowest;
    const auto energy_of = [&](ptrdiff_t disparity) HWY_ATTR {
      return hn::LoadU(d, right_energies_ + (first_right - disparity));
    };
    const auto cross_of = [&](ptrdiff_t disparity)
                              HWY_ATTR { return left.Products(right_, first_right - disparity); };
    // Lanes of which none may fit are excluded anyway.
    const M is_lowest = hn::Eq(from, hn::Set(d, lowest));
    const M is_lowest_or_none = hn::Or(is_lowest, hn::Eq(from, hn::Set(d, kNone)));
    if (hn::AllTrue(d, is_lowest_or_none)) {  // as most neighbours: all have the same
      HWY_UNROLL(4)
      for (int i = 0; i < kCosts; ++i) {
        sums.energy[i] = energy_of(i);
        sums.cross[i] = cross_of(i);
      }
      return sums;
    }
    if (hn::AllTrue(d, hn::Or(is_lowest_or_none, hn::Eq(from, hn::Set(d, lowest + 1))))) {
      // All pixels have the lowest disparity or the next one, as on a slanted surface.
      V energy = energy_of(0);
      V cross = cross_of(0);
      HWY_UNROLL(4)
      for (int i = 0; i < kCosts; ++i) {
        const V next_energy = energy_of(i + 1);
        const V next_cross = cross_of(i + 1);
        sums.energy[i] = hn::IfThenElse(is_lowest, energy, next_energy);
        sums.cross[i] = hn::IfThenElse(is_lowest, cross, next_cross);
        energy = next_energy;
        cross = next_cross;
      }
      return sums;
    }
    for (int disparity = lowest; disparity != kNone; ++disparity) {
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
      const V energy = energy_of(disparity - lowest);
      const V cross = cross_of(disparity - lowest);
      HWY_UNROLL(4)
      for (int i = 0; i < kCosts; ++i) {
        const M here = hn::Eq(from, hn::Set(d, disparity - i));
        sums.energy[i] = hn::IfThenElse(here, energy, sums.energy[i]);
        sums.cross[i] = hn::IfThenElse(here, cross, sums.cross[i]);
      }
    }
    return sums;
  }

  const GrowthRule& rule_;
  const ChoiceInput& row_;
  const WindowPairs right_;
  const int32_t* const right_energies_;
};

}  // namespace HWY_NAMESPACE
}  // namespace sprout::grow
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
