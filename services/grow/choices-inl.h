// The better one of a pixel's two candidates, for each instruction set: included by
// sweep_kernel.cc, which Highway compiles once for each, so it has no usual include guard.
#if defined(SPROUT_SERVICES_GROW_CHOICES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SPROUT_SERVICES_GROW_CHOICES_INL_H_
#undef SPROUT_SERVICES_GROW_CHOICES_INL_H_
#else
#define SPROUT_SERVICES_GROW_CHOICES_INL_H_
#endif

#include <hwy/highway.h>

#include <array>

#include "services/grow/sweep_band.h"
#include "services/grow/window_costs-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sprout::grow {
namespace HWY_NAMESPACE {

// Rows of pairs (PairProducts()) that hold the five rows of a window: its rows 0 and 1, 2 and 3, 4.
// The lower pixels of the last pairs are not in the window.
using WindowPairs = std::array<const int32_t*, 3>;

// Pairs of columns, whose products give sums over the columns of a window.
template <class D>
class Columns {
 public:
  using V = hn::Vec<D>;

  // @param u  the first column; as many as there are lanes.
  HWY_INLINE Columns(const WindowPairs& pairs, int u)
      : pairs_{hn::LoadU(D(), pairs[0] + u), hn::LoadU(D(), pairs[1] + u),
               hn::And(hn::LoadU(D(), pairs[2] + u), hn::Set(D(), 0xffff))} {}

  // Σ of the products in each column. @param u  the other column that belongs to the first one.
  HWY_INLINE V Products(const WindowPairs& others, int u) const {
    const auto sums = [&](size_t i) HWY_ATTR {
      return PairProducts(pairs_[i], hn::LoadU(D(), others[i] + u));
    };
    return hn::Add(hn::Add(sums(0), sums(1)), sums(2));
  }

 private:
  V pairs_[3];
};

// The windows of neighbouring pixels, as many as D has lanes.
template <class D>
class WindowRun {
 public:
  using V = hn::Vec<D>;

  // @param u  the first pixel.
  HWY_INLINE WindowRun(const WindowPairs& pairs, int u)
      : columns_(pairs, u - kWindowRadius), columns_behind_(pairs, u + kWindowRadius) {}

  // Σ of the products with other windows. Reads as many columns whether they fit or not.
  // @param u  the pixel that belongs to the first one.
  HWY_INLINE V Products(const WindowPairs& others, int u) const {
    const D d;
    const V columns = columns_.Products(others, u - kWindowRadius);
    const V behind = columns_behind_.Products(others, u + kWindowRadius);  // four lanes on
    const V two = hn::Add(columns, hn::CombineShiftRightLanes<1>(d, behind, columns));
    const V three = hn::Add(two, hn::CombineShiftRightLanes<2>(d, behind, columns));
    return hn::Add(hn::Add(three, hn::CombineShiftRightLanes<3>(d, behind, columns)), behind);
  }

 private:
  Columns<D> columns_, columns_behind_;
};

// What the choice reads of a row. All can be read kRunPixels behind the row's end, pairs and
// energies also before its start.
struct ChoiceInput {
  WindowPairs left;
  WindowPairs right;
  const int32_t* left_energies;   // Σ wL²
  const int32_t* left_textures;   // Σ(wL − wL′)², wL′ one pixel before; only with sub_pixel
  const int32_t* right_energies;  // Σ wR²
  const int16_t* priors;          // counts
  const uint8_t* sigmas;          // of the priors, counts
  int width;
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
template <bool kSubPixel>
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
      const M open = hn::And(inside, hn::Gt(sigma, hn::Set(d, rule_.least_open - 1)));
      any_open = hn::Or(any_open, open);
      const M sure = hn::AndNot(open, inside);
      const Best best = BestOfTwo(u, prior, sure);
      const M accepted = hn::AndNot(hn::Gt(best.cost, hn::Set(d, rule_.limit)), sure);
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
    return !hn::AllFalse(d, any_open);
  }

 private:
  using D = hn::CappedTag<int32_t, kRunPixels>;
  using V = hn::Vec<D>;
  using M = hn::Mask<D>;
  static constexpr int kLanes = static_cast<int>(hn::MaxLanes(D()));

  // The disparities whose costs are needed: from m − kBefore on.
  static constexpr int kBefore = kSubPixel ? 1 : 0;
  static constexpr int kCosts = 2 + 2 * kBefore;

  struct Best {
    V disparity, cost, step;
  };

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

  // Of m and m + 1 at the pixels from u on. @param wanted  the others' do not matter.
  HWY_INLINE Best BestOfTwo(int u, V prior, M wanted) const {
    const D d;
    const V columns = hn::Iota(d, u);
    const V first = hn::ShiftRight<5>(prior);
    const WindowRun<D> left(row_.left, u);
    const V left_energy = hn::LoadU(d, row_.left_energies + u);
    const Sums sums = SumWindows(left, u, first, hn::And(wanted, MayFit(columns, first)));
    const auto cost_at = [&](V steps, V energy, V cross) HWY_ATTR {
      const V fraction = hn::And(prior, hn::Set(d, DisparityImage::kCountsPerPixel - 1));
      const V distance = hn::Sub(hn::ShiftLeft<5>(steps), fraction);
      const V disparity = hn::Add(first, steps);
      const V room = hn::Sub(hn::Sub(columns, disparity), hn::Set(d, kWindowRadius));
      const M misfit = hn::Lt(hn::Or(disparity, room), hn::Zero(d));
      return EpcCosts(rule_, hn::Add(left_energy, energy), cross, distance, rule_.prior_scales[0],
                      misfit);
    };
    const V cost = cost_at(hn::Zero(d), sums.energy[kBefore], sums.cross[kBefore]);
    const V cost_of_next =
        cost_at(hn::Set(d, 1), sums.energy[kBefore + 1], sums.cross[kBefore + 1]);
    const M next_is_better = hn::Lt(cost_of_next, cost);
    const auto choose = [&](V if_next, V if_not)
                            HWY_ATTR { return hn::IfThenElse(next_is_better, if_next, if_not); };
    Best best{choose(hn::Add(first, hn::Set(d, 1)), first), hn::Min(cost, cost_of_next),
              hn::Zero(d)};
    if constexpr (kSubPixel) {
      const V beyond =
          cost_at(choose(hn::Set(d, 2), hn::Set(d, -1)), choose(sums.energy[3], sums.energy[0]),
                  choose(sums.cross[3], sums.cross[0]));
      const V energy = hn::Add(left_energy, choose(sums.energy[2], sums.energy[1]));
      const auto difference = [&](size_t if_next, size_t if_not) HWY_ATTR {
        const V cross = choose(sums.cross[if_next], sums.cross[if_not]);
        return hn::Sub(hn::Add(left_energy, choose(sums.energy[if_next], sums.energy[if_not])),
                       hn::Add(cross, cross));
      };
      const V distance = hn::Sub(hn::ShiftLeft<5>(best.disparity), prior);
      best.step = StepsToMinimum(
          rule_,
          StepWindows<V>{difference(1, 0), difference(2, 1), difference(3, 2), choose(cost, beyond),
                         best.cost, choose(beyond, cost_of_next),
                         hn::LoadU(d, row_.left_textures + u),
                         hn::LoadU(d, row_.left_textures + u + 1), energy, distance},
          rule_.prior_scales[0]);
      // At the last pixel the next one has no window.
      const V columns_left = hn::Sub(hn::Set(d, row_.width - kWindowRadius - 1), columns);
      best.step = hn::IfThenElseZero(hn::Gt(columns_left, hn::Zero(d)), best.step);
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
    if (hn::AllTrue(d, hn::Or(hn::Eq(from, hn::Set(d, lowest)), hn::Eq(from, hn::Set(d, kNone))))) {
      // As most neighbours: all have the same. Lanes of which none may fit are excluded anyway.
      HWY_UNROLL(4)
      for (int i = 0; i < kCosts; ++i) {
        sums.energy[i] = hn::LoadU(d, right_energies_ + (u - lowest - i));
        sums.cross[i] = left.Products(right_, u - lowest - i);
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
      const V energy = hn::LoadU(d, right_energies_ + (u - disparity));
      const V cross = left.Products(right_, u - disparity);
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
