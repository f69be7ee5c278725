// Sums over the windows of neighbouring pixels, for each instruction set: Highway compiles this
// file once for each, so it has no usual include guard.
#if defined(SPROUT_SERVICES_GROW_WINDOW_RUNS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SPROUT_SERVICES_GROW_WINDOW_RUNS_INL_H_
#undef SPROUT_SERVICES_GROW_WINDOW_RUNS_INL_H_
#else
#define SPROUT_SERVICES_GROW_WINDOW_RUNS_INL_H_
#endif

#include <hwy/highway.h>

#include <array>

#include "services/grow/sweep/window_costs-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sprout::grow {
namespace HWY_NAMESPACE {

// As many neighbouring pixels as are looked at together.
using RunTag = hn::CappedTag<int32_t, kRunPixels>;

// Rows of pairs (PairProducts()) that hold the five rows of a window: its rows 0 and 1, 2 and 3, 4.
// The lower pixels of the last pairs are not in the window.
using WindowPairs = std::array<const int32_t*, 3>;

// Pairs of columns, whose products give sums over the columns of a window.
template <class D>
class Columns {
 public:
  using V = hn::Vec<D>;

  // @param u  the first column; as many as there are lanes.
  HWY_INLINE Columns(const WindowPairs& pairs, ptrdiff_t u)
      : pairs_{hn::LoadU(D(), pairs[0] + u), hn::LoadU(D(), pairs[1] + u),
               hn::And(hn::LoadU(D(), pairs[2] + u), hn::Set(D(), 0xffff))} {}

  // Σ of the squares in each column.
  HWY_INLINE V Squares() const {
    const auto sums = [&](size_t i) HWY_ATTR { return PairProducts(pairs_[i], pairs_[i]); };
    return hn::Add(hn::Add(sums(0), sums(1)), sums(2));
  }

  // Σ of the squared differences from others. @param u  the other column that belongs to the first.
  HWY_INLINE V SquaredDifferences(const WindowPairs& others, ptrdiff_t u) const {
    const hn::Repartition<int16_t, D> d16;
    const auto sums = [&](size_t i) HWY_ATTR {
      const V other = hn::LoadU(D(), others[i] + u);
      const V difference =
          hn::BitCast(D(), hn::Abs(hn::Sub(hn::BitCast(d16, pairs_[i]), hn::BitCast(d16, other))));
      const V in_window = i == 2 ? hn::And(difference, hn::Set(D(), 0xffff)) : difference;
      return PairProducts(in_window, in_window);
    };
    return hn::Add(hn::Add(sums(0), sums(1)), sums(2));
  }

  // Σ of the products in each column. @param u  the other column that belongs to the first one.
  HWY_INLINE V Products(const WindowPairs& others, ptrdiff_t u) const {
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
  HWY_INLINE WindowRun(const WindowPairs& pairs, ptrdiff_t u)
      : columns_(pairs, u - kWindowRadius), columns_behind_(pairs, u + kWindowRadius) {}

  // Σ of the products with other windows. Reads as many columns whether they fit or not.
  // @param u  the pixel that belongs to the first one.
  HWY_INLINE V Products(const WindowPairs& others, ptrdiff_t u) const {
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

// Sums over windows of sums over their columns, at the pixels from u on.
template <class D>
HWY_INLINE hn::Vec<D> SumColumns(D d, const int32_t* columns, ptrdiff_t u) {
  static_assert(kWindowRadius == 2);
  const auto at = [&](int x) HWY_ATTR { return hn::LoadU(d, columns + u + x); };
  return hn::Add(hn::Add(hn::Add(at(-2), at(-1)), hn::Add(at(0), at(1))), at(2));
}

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
};

// What such pixels choose. V: a vector of whole numbers.
template <class V>
struct ChoiceOf {
  V disparity, cost;
  V step;  // counts from the disparity to the least cost; only with sub_pixel
};

}  // namespace HWY_NAMESPACE
}  // namespace sprout::grow
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
