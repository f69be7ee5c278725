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

// Computes the candidates of as many pixels of a row at once as a register has lanes.
class CandidateSweep {
 public:
  CandidateSweep(const GrowthRule& rule, GrowthBand& band) : rule_(rule), queue_(band.queue) {}

  // Replaces energies by candidates in the columns [begin, end).
  void Replace(const GrowthRow& row, int begin, int end) {
    for (int u = begin; u < end; u += kLanes) {
      const int count = std::min(kLanes, end - u);
      for (int i = 0; i < count; ++i) Take(row, u + i, static_cast<size_t>(i));
      Compute();
      for (int i = 0; i < count; ++i) Put(row, u + i, static_cast<size_t>(i));
    }
  }

 private:
  using D = hn::CappedTag<int32_t, 16>;
  using V = hn::Vec<D>;
  static constexpr int kLanes = static_cast<int>(hn::MaxLanes(D()));
  using Numbers = std::array<int32_t, kLanes>;

  HWY_INLINE void Take(const GrowthRow& row, int u, size_t lane) {
    const LeftPixel& pixel = row.left[u];
    const int m = FirstCandidate(pixel);
    const bool fits = m >= -1 && m <= u - kWindowRadius;  // the window of one of them may
    prior_[lane] = pixel.prior;
    energy_[lane] = fits ? pixel.energy : GrowthBand::kOutside;
    const int d = fits ? m + 1 : 1;
    right_energies_[lane] = ToNumbers(RightEnergies(row, u, d));
    cross_sums_[lane] = ToNumbers(CrossSums(row, u, d));
  }

  HWY_INLINE void Compute() {
    const D d;
    V energy[4], cross[4];  // of m + 2, m + 1, m, m − 1
    hn::LoadInterleaved4(d, right_energies_[0].data(), energy[0], energy[1], energy[2], energy[3]);
    hn::LoadInterleaved4(d, cross_sums_[0].data(), cross[0], cross[1], cross[2], cross[3]);
    const V left_energy = hn::LoadU(d, energy_.data());
    const V prior = hn::LoadU(d, prior_.data());
    const V first = hn::ShiftRight<5>(prior);
    const V fraction = hn::And(prior, hn::Set(d, DisparityImage::kCountsPerPixel - 1));
    const auto cost = [&](int i) HWY_ATTR {
      const V steps = hn::Set(d, 2 - i);
      const V distance = hn::Sub(hn::ShiftLeft<5>(steps), fraction);
      const auto photo =
          PhotoCosts<GrowConfig::EPC>(rule_, hn::Add(left_energy, energy[i]), cross[i]);
      return WholeCosts(hn::Add(photo, PriorCosts(rule_, distance)), hn::Or(left_energy, energy[i]),
                        hn::Add(first, steps));
    };
    const V best = cost(2), next = cost(1);
    hn::StoreU(Packed(best, next), d, candidates_.data());
    if (!rule_.sub_pixel) return;
    const V step = hn::And(StepsToMinimum(cost(3), best, next), hn::Set(d, 0xff));
    const V step_of_next = hn::And(StepsToMinimum(best, next, cost(0)), hn::Set(d, 0xff));
    hn::StoreU(hn::Or(step, hn::ShiftLeft<8>(step_of_next)), d, steps_.data());
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

  HWY_INLINE void Put(const GrowthRow& row, int u, size_t lane) const {
    row.left[u].candidates = Candidates(static_cast<uint32_t>(candidates_[lane]));
    if (rule_.sub_pixel) {
      row.sub_pixel_steps[u] = SubPixelSteps(static_cast<uint16_t>(steps_[lane]));
    }
  }

  const GrowthRule& rule_;
  const SeedQueue& queue_;
  Numbers prior_{}, energy_{}, candidates_{}, steps_{};
  std::array<FourNumbers, kLanes> right_energies_{}, cross_sums_{};
};

// Replaces the energies of a band by the candidates of its pixels.
HWY_INLINE void Tabulate(const GrowthRule& rule, GrowthBand& band) {
  CandidateSweep sweep(rule, band);
  for (int r = 0; r < band.rows(); ++r) {
    sweep.Replace(band.row(r), kWindowRadius, band.width() - kWindowRadius);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace sprout
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
