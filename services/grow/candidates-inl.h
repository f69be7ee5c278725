// What pixels with two candidates can be matched to, for each instruction set: included by
// growth_kernel.cc, which Highway compiles once for each. No include guard of the usual kind for
// that reason.
#if defined(SPROUT_SERVICES_GROW_CANDIDATES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SPROUT_SERVICES_GROW_CANDIDATES_INL_H_
#undef SPROUT_SERVICES_GROW_CANDIDATES_INL_H_
#else
#define SPROUT_SERVICES_GROW_CANDIDATES_INL_H_
#endif

#include <hwy/highway.h>

#include <array>

#include "services/grow/growth_band.h"
#include "services/grow/window_costs-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sprout::grow {
namespace HWY_NAMESPACE {

// Rows of pairs (PairProducts()) that hold the five rows of a window: its rows 0 and 1, 2 and 3, 4.
// Of the last pairs the lower pixels are not the window's.
using WindowPairs = std::array<const int32_t*, 3>;

// Pairs of columns, of which products give sums over columns of a window.
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
      : columns_(pairs, u - kWindowRadius), last_columns_(pairs, u - kWindowRadius + kLanes) {}

  // Σ of the products with other windows. Reads as many columns whether they fit or not.
  // @param u  the pixel that belongs to the first one.
  HWY_INLINE V Products(const WindowPairs& others, int u) const {
    const D d;
    const int first = u - kWindowRadius;
    const V columns = columns_.Products(others, first);
    const V behind = FourOn(columns, last_columns_.Products(others, first + kLanes));
    const V two = hn::Add(columns, hn::CombineShiftRightLanes<1>(d, behind, columns));
    const V three = hn::Add(two, hn::CombineShiftRightLanes<2>(d, behind, columns));
    return hn::Add(hn::Add(three, hn::CombineShiftRightLanes<3>(d, behind, columns)), behind);
  }

 private:
  static constexpr int kLanes = static_cast<int>(hn::MaxLanes(D()));

  // What lies four lanes on. @param last  follows on the last lane.
  static HWY_INLINE V FourOn(V columns, Four last) {
    if constexpr (kLanes == 4) {
      return last;
    } else {
      alignas(16) int32_t numbers[4];
      hn::Store(last, DFour(), numbers);
      static constexpr auto kFourOn = [] {
        std::array<int32_t, kLanes> lanes{};
        for (int lane = 0; lane < kLanes; ++lane) {
          lanes[static_cast<size_t>(lane)] = (lane + 4) % kLanes;
        }
        return lanes;
      }();
      return hn::IfThenElse(hn::FirstN(D(), kLanes - 4),
                            hn::TableLookupLanes(columns, hn::SetTableIndices(D(), kFourOn.data())),
                            hn::LoadDup128(D(), numbers));
    }
  }

  Columns<D> columns_;
  Columns<DFour> last_columns_;
};

// What the sweep over a row reads. All can be read kRunPixels behind the row's end, pairs and
// energies also before its start.
struct SweepRow {
  WindowPairs left;
  WindowPairs right;
  const int32_t* right_energies;  // Σ wR²
  const int16_t* priors;          // counts
  const uint8_t* sigmas;          // of the priors, counts
};

// Fills the pixels of a row, as many neighbours at once as a register has lanes. Neighbours need
// about the same disparities, and their windows share columns: for one disparity all the windows
// cost little more than two of them would alone.
template <bool kSubPixel>
class CandidateSweep {
 public:
  CandidateSweep(const GrowthRule& rule, const SweepRow& row)
      : rule_(rule), row_(row), right_(row.right), right_energies_(row.right_energies) {}

  // Pixels that can have no match are closed, as are those behind the row's end.
  // @param steps  of GrowthBand. @returns whether a pixel is open.
  bool Fill(int width, LeftPixel* pixels, int8_t* steps) const {
    const D d;
    const hn::Rebind<int16_t, D> d16;
    const hn::Rebind<uint8_t, D> d8;
    M any_open = hn::FirstN(d, 0);
    for (int u = kWindowRadius; u < width - kWindowRadius; u += kLanes) {
      const V prior = hn::PromoteTo(d, hn::LoadU(d16, row_.priors + u));
      const V sigma = hn::PromoteTo(d, hn::LoadU(d8, row_.sigmas + u));
      const M inside = hn::AndNot(hn::Eq(prior, hn::Set(d, DisparityImage::kInvalid)),
                                  hn::Lt(hn::Iota(d, u), hn::Set(d, width - kWindowRadius)));
      const M open = hn::And(inside, hn::Gt(sigma, hn::Set(d, rule_.least_open - 1)));
      const M tabled = hn::AndNot(open, inside);
      const V candidates = hn::IfThenElse(open, hn::Or(sigma, hn::Set(d, 1 << Candidates::kOpen)),
                                          Compute(u, prior, tabled, steps + u));
      const M hopeless =
          hn::Or(hn::Not(inside), hn::Lt(candidates, hn::Set(d, 1 << Candidates::kAccepted)));
      const V state =
          hn::IfThenElse(hopeless, hn::Set(d, LeftPixel::kClosed), hn::Set(d, LeftPixel::kFree));
      LeftPixels<D>(candidates, prior, state).Store(pixels + u);
      any_open = hn::Or(any_open, open);
    }
    return !hn::AllFalse(d, any_open);
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

  // Candidates of the pixels from u on. @param wanted  the others' do not matter.
  HWY_INLINE V Compute(int u, V prior, M wanted, int8_t* steps_to) const {
    const D d;
    const V columns = hn::Iota(d, u);
    const V first = hn::ShiftRight<5>(prior);
    const WindowRun<D> left(row_.left, u);
    const V left_energy = left.Products(row_.left, u);
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
      hn::StoreU(hn::DemoteTo(d8, packed), d8, steps_to);
    }
    return Packed(cost, cost_of_next);
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

  // As GrowthRule::LevelOf().
  HWY_INLINE V Levels(V costs) const {
    const D d;
    const V in_range = hn::Min(costs, hn::Set(d, rule_.limit));
    return hn::ShiftRight<GrowthRule::kLevelFraction>(
        hn::Mul(in_range, hn::Set(d, rule_.levels_per_cost)));
  }

  const GrowthRule& rule_;
  const SweepRow& row_;
  const WindowPairs right_;
  const int32_t* const right_energies_;
};

// Fills the tables of a band row by row: pairs of pixels and energies of one window's rows at a
// time stay in the cache.
class BandTables {
 public:
  BandTables(const GrowthRule& rule, const GrowthInput& input, GrowthBand& band)
      : rule_(rule),
        input_(input),
        band_(band),
        left_pairs_(kWindow * RowSize()),
        right_pairs_(kWindow * RowSize()),
        right_energies_(RowSize()),
        priors_(RowSize()),
        sigmas_(RowSize()) {}

  void Fill() {
    for (int r = -kWindowRadius; r < kWindowRadius; ++r) AddPairs(r);
    for (int r = 0; r < band_.rows; ++r) {
      AddPairs(r + kWindowRadius);
      const int v = band_.first_row + r;
      if (v >= kWindowRadius && v < band_.image_size.height - kWindowRadius) FillRow(r);
    }
  }

 private:
  using D = hn::CappedTag<int32_t, GrowthBand::kRunPixels>;
  static constexpr int kLanes = static_cast<int>(hn::MaxLanes(D()));
  static constexpr int kBehind = 2 * GrowthBand::kRunPixels;  // a run and its windows

  int width() const { return band_.image_size.width; }
  size_t RowSize() const { return static_cast<size_t>(kBehind + width() + kBehind); }

  // Of rows r and r + 1 of the band, kept for as long as a window needs them.
  int32_t* PairRow(std::vector<int32_t>& pairs, int r) const {
    return pairs.data() + static_cast<size_t>((r + kWindow) % kWindow) * RowSize() + kBehind;
  }
  WindowPairs Around(std::vector<int32_t>& pairs, int r) const {
    return {PairRow(pairs, r - 2), PairRow(pairs, r), PairRow(pairs, r + 2)};
  }

  void AddPairs(int r) {
    // Below the last row of all there is none, and no window reads its pixels.
    const PixelId upper = band_.PixelAt(r, 0);
    const PixelId lower = band_.PixelAt(std::min(r + 1, band_.rows + GrowthBand::kMargin - 1), 0);
    const auto add = [&](const std::vector<uint8_t>& grey, int32_t* pairs) HWY_ATTR {
      const D d;
      const hn::Rebind<uint8_t, D> d8;
      for (int u = 0; u < width(); u += kLanes) {
        const auto at = static_cast<size_t>(u);
        const auto one = hn::PromoteTo(d, hn::LoadU(d8, grey.data() + upper + at));
        const auto other = hn::PromoteTo(d, hn::LoadU(d8, grey.data() + lower + at));
        hn::StoreU(hn::Or(one, hn::ShiftLeft<16>(other)), d, pairs + u);
      }
    };
    add(band_.left_grey, PairRow(left_pairs_, r));
    add(band_.right_grey, PairRow(right_pairs_, r));
  }

  void FillRow(int r) {
    const D d;
    const WindowPairs right = Around(right_pairs_, r);
    int32_t* const right_energies = right_energies_.data() + kBehind;
    for (int u = kWindowRadius; u < width() - kWindowRadius; u += kLanes) {
      hn::StoreU(WindowRun<D>(right, u).Products(right, u), d, right_energies + u);
    }
    const int v = band_.first_row + r;
    std::copy_n(input_.prior.disparity.counts()[v], width(), priors_.data());
    std::copy_n(input_.prior.sigma[v], width(), sigmas_.data());
    const SweepRow row{Around(left_pairs_, r), right, right_energies, priors_.data(),
                       sigmas_.data()};
    LeftPixel* const pixels = band_.left.data() + band_.PixelAt(r, 0);
    int8_t* const steps = band_.steps.data() + band_.PixelAt(r, 0);
    band_.has_open[static_cast<size_t>(r)] =
        rule_.sub_pixel ? CandidateSweep<true>(rule_, row).Fill(width(), pixels, steps)
                        : CandidateSweep<false>(rule_, row).Fill(width(), pixels, steps);
  }

  const GrowthRule& rule_;
  const GrowthInput& input_;
  GrowthBand& band_;
  std::vector<int32_t> left_pairs_, right_pairs_, right_energies_;
  std::vector<int16_t> priors_;
  std::vector<uint8_t> sigmas_;
};

}  // namespace HWY_NAMESPACE
}  // namespace sprout::grow
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
