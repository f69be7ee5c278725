// The best of all a pixel's candidates where these are more than two, for each instruction set:
// included by choices-inl.h, which Highway compiles once for each, so it has no usual include
// guard.
#if defined(SPROUT_SERVICES_GROW_WIDE_CHOICES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SPROUT_SERVICES_GROW_WIDE_CHOICES_INL_H_
#undef SPROUT_SERVICES_GROW_WIDE_CHOICES_INL_H_
#else
#define SPROUT_SERVICES_GROW_WIDE_CHOICES_INL_H_
#endif

#include <hwy/highway.h>

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

}  // namespace HWY_NAMESPACE
}  // namespace sprout::grow
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
