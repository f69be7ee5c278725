// Steps (W1) and (W2) of the sweep. Highway compiles this file once for each instruction set and
// picks one when the program runs.
#include <algorithm>
#include <bit>
#include <cstring>
#include <type_traits>
#include <vector>

#include "services/grow/sweep/sweep_band.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "services/grow/sweep/sweep_kernel.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#if HWY_TARGET != HWY_SCALAR
#include "services/grow/sweep/choices-inl.h"
#endif

HWY_BEFORE_NAMESPACE();
namespace sprout::grow {
namespace HWY_NAMESPACE {

#if HWY_TARGET == HWY_SCALAR

SweepFunction SweepOnTarget() { return nullptr; }

#else

// Pixels of 16 bits.
using D16 = hn::CappedTag<int16_t, 2 * kRunPixels>;
using V16 = hn::Vec<D16>;
inline constexpr int kLanes16 = static_cast<int>(hn::MaxLanes(D16()));

inline constexpr int kBeside = 4 * kRunPixels;  // entries on either side of a row

// Sweeps one row after the other: the sums of one window's rows stay in the cache.
class Sweep {
 public:
  Sweep(const GrowthRule& rule, const GrowthInput& input, SweepBand& band, DisparityImage& map)
      : rule_(rule),
        input_(input),
        band_(band),
        map_(map),
        width_(input.left.cols),
        height_(input.left.rows),
        row_size_(static_cast<size_t>(kBeside + width_ + kBeside)),
        left_pairs_(kWindow * row_size_),
        right_pairs_(kWindow * row_size_),
        left_columns_(row_size_),
        texture_columns_(row_size_),
        right_columns_(row_size_),
        left_energies_(row_size_),
        left_textures_(row_size_),
        right_energies_(row_size_),
        priors_(row_size_),
        sigmas_(row_size_),
        disparities_(row_size_, ChoiceRow::kNone),
        keys_(row_size_, ChoiceRow::kNoKey),
        steps_(row_size_),
        least_keys_(row_size_, ChoiceRow::kNoKey) {}

  void Run() {
    const auto rows = static_cast<size_t>(band_.rows);
    band_.has_open.assign(rows, 0);
    band_.words_per_row = static_cast<size_t>(width_ + 63) / 64;
    band_.cuts.assign(rows * band_.words_per_row, 0);
    band_.first_lost.assign(1, 0);
    for (int r = -kWindowRadius; r < kWindowRadius; ++r) AddPairs(r);
    for (int r = 0; r < band_.rows; ++r) {
      AddPairs(r + kWindowRadius);
      const int v = band_.first_row + r;
      int16_t* const counts = map_.counts()[v];
      if (v >= kWindowRadius && v < height_ - kWindowRadius) {
        band_.has_open[static_cast<size_t>(r)] = Choose(r) ? 1 : 0;
        Assign(counts);
        Cut(r);
      } else {
        std::fill_n(counts, width_, DisparityImage::kInvalid);
      }
      band_.first_lost.push_back(lost_count_);
    }
  }

 private:
  using D = hn::CappedTag<int32_t, kRunPixels>;
  static constexpr int kLanes = static_cast<int>(hn::MaxLanes(D()));

  // Sums of pairs of rows r and r + 1 of the band, kept for as long as a window needs them.
  int32_t* PairRow(std::vector<int32_t>& pairs, int r) const {
    return pairs.data() + static_cast<size_t>((r + kWindow) % kWindow) * row_size_ + kBeside;
  }
  WindowPairs Around(std::vector<int32_t>& pairs, int r) const {
    return {PairRow(pairs, r - 2), PairRow(pairs, r), PairRow(pairs, r + 2)};
  }

  void AddPairs(int r) {
    // There are no rows beyond the image, and no window reads these sums.
    const int upper = std::clamp(band_.first_row + r, 0, height_ - 1);
    const int lower = std::clamp(band_.first_row + r + 1, 0, height_ - 1);
    const auto add = [&](const cv::Mat1b& grey, int32_t* pairs) HWY_ATTR {
      const D d;
      const hn::Rebind<uint8_t, D> d8;
      const uint8_t* const above = grey[upper];
      const uint8_t* const below = grey[lower];
      int u = 0;
      for (; u + kLanes <= width_; u += kLanes) {
        const auto one = hn::PromoteTo(d, hn::LoadU(d8, above + u));
        const auto other = hn::PromoteTo(d, hn::LoadU(d8, below + u));
        hn::StoreU(hn::Or(one, hn::ShiftLeft<16>(other)), d, pairs + u);
      }
      for (; u < width_; ++u) pairs[u] = above[u] | below[u] << 16;
    };
    add(input_.left, PairRow(left_pairs_, r));
    add(input_.right, PairRow(right_pairs_, r));
  }

  // The sums over windows that do not depend on the disparity: first over columns, which windows of
  // neighbouring pixels share.
  void AddUpWindows(const WindowPairs& left, const WindowPairs& right) {
    const D d;
    const auto row = [](std::vector<int32_t>& numbers) { return numbers.data() + kBeside; };
    int32_t* const left_columns = row(left_columns_);
    int32_t* const texture_columns = row(texture_columns_);
    int32_t* const right_columns = row(right_columns_);
    for (int u = 0; u < width_; u += kLanes) {
      const Columns<D> columns(left, u);
      hn::StoreU(columns.Squares(), d, left_columns + u);
      hn::StoreU(Columns<D>(right, u).Squares(), d, right_columns + u);
      if (!rule_.sub_pixel) continue;
      hn::StoreU(columns.SquaredDifferences(left, u - 1), d, texture_columns + u);
    }
    int32_t* const left_energies = row(left_energies_);
    int32_t* const left_textures = row(left_textures_);
    int32_t* const right_energies = row(right_energies_);
    for (int u = kWindowRadius; u < width_ - kWindowRadius; u += kLanes) {
      hn::StoreU(SumColumns(d, left_columns, u), d, left_energies + u);
      hn::StoreU(SumColumns(d, right_columns, u), d, right_energies + u);
      if (!rule_.sub_pixel) continue;
      hn::StoreU(SumColumns(d, texture_columns, u), d, left_textures + u);
    }
  }

  // (W1). @returns whether a pixel is open.
  bool Choose(int r) {
    const WindowPairs right = Around(right_pairs_, r);
    const WindowPairs left = Around(left_pairs_, r);
    AddUpWindows(left, right);
    const int v = band_.first_row + r;
    std::copy_n(input_.prior.disparity.counts()[v], width_, priors_.data());
    std::copy_n(input_.prior.sigma[v], width_, sigmas_.data());
    const ChoiceInput row{left,
                          right,
                          left_energies_.data() + kBeside,
                          left_textures_.data() + kBeside,
                          right_energies_.data() + kBeside,
                          priors_.data(),
                          sigmas_.data()};
    const ChoiceRow to{disparities_.data() + kBeside, keys_.data() + kBeside,
                       steps_.data() + kBeside};
    const auto choose = [&](auto is_wide) HWY_ATTR {
      constexpr bool kWide = decltype(is_wide)::value;
      return rule_.sub_pixel ? Choice<true, kWide>(rule_, row).Run(width_, to)
                             : Choice<false, kWide>(rule_, row).Run(width_, to);
    };
    const uint8_t* const sigmas = sigmas_.data();
    uint8_t unsurest = 0;
    for (int u = 0; u < width_; ++u) unsurest = std::max(unsurest, sigmas[u]);
    return unsurest >= rule_.min_wide_sigma ? choose(std::true_type()) : choose(std::false_type());
  }

  // Calls act(u − d, mask) for each disparity d that there is among the pixels from u on, which are
  // few: neighbours mostly have the same. @param mask  the lanes that have it.
  template <class Act>
  static HWY_INLINE void ForEachDisparity(const int16_t* disparities, int u, const Act& act) {
    const D16 d;
    const V16 here = hn::LoadU(d, disparities + u);
    auto rest = hn::Ne(here, hn::Set(d, ChoiceRow::kNone));
    for (intptr_t lane = hn::FindFirstTrue(d, rest); lane >= 0; lane = hn::FindFirstTrue(d, rest)) {
      const int16_t disparity = disparities[u + lane];
      const auto mask = hn::Eq(here, hn::Set(d, disparity));
      act(u - disparity, mask);
      rest = hn::AndNot(mask, rest);
    }
  }

  // (W2). Keys are even: an odd one says that two had the next one, and nobody wins.
  void Assign(int16_t* counts) {
    const D16 d;
    const int16_t* const disparities = disparities_.data() + kBeside;
    const int16_t* const keys = keys_.data() + kBeside;
    int16_t* const least = least_keys_.data() + kBeside;
    std::fill_n(least, width_, ChoiceRow::kNoKey);
    for (int u = kWindowRadius; u < width_ - kWindowRadius; u += kLanes16) {
      const V16 key = hn::LoadU(d, keys + u);
      ForEachDisparity(disparities, u, [&](int right, auto mask) HWY_ATTR {
        const V16 before = hn::LoadU(d, least + right);
        const V16 claim = hn::IfThenElse(mask, key, hn::Set(d, ChoiceRow::kNoKey));
        const V16 tied = hn::VecFromMask(d, hn::And(mask, hn::Eq(before, key)));  // −1
        hn::StoreU(hn::Add(hn::Min(before, claim), tied), d, least + right);
      });
    }
    std::fill_n(counts, kWindowRadius, DisparityImage::kInvalid);
    for (int u = kWindowRadius; u < width_; u += kLanes16) {
      const V16 key = hn::LoadU(d, keys + u);
      auto wins = hn::FirstN(d, 0);
      ForEachDisparity(disparities, u, [&](int right, auto mask) HWY_ATTR {
        wins = hn::Or(wins, hn::And(mask, hn::Eq(hn::LoadU(d, least + right), key)));
      });
      KeepLost(u, wins);
      WriteWon(u, wins, counts);
    }
  }

  HWY_INLINE void KeepLost(int u, hn::Mask<D16> wins) {
    const D16 d;
    const V16 disparity = hn::LoadU(d, disparities_.data() + kBeside + u);
    const auto lost = hn::AndNot(wins, hn::Ne(disparity, hn::Set(d, ChoiceRow::kNone)));
    uint8_t bytes[8] = {};
    hn::StoreMaskBits(d, lost, bytes);
    uint64_t bits;
    std::memcpy(&bits, bytes, sizeof(bits));
    if (bits == 0) return;
    const auto room = static_cast<size_t>(lost_count_ + kLanes16);
    if (room > band_.lost.size()) band_.lost.resize(2 * room);
    for (; bits != 0; bits &= bits - 1) {
      const int at = u + std::countr_zero(bits);
      const auto i = static_cast<size_t>(kBeside + at);
      const int16_t step = rule_.sub_pixel ? steps_[i] : int16_t{0};
      band_.lost[static_cast<size_t>(lost_count_++)] = {keys_[i], static_cast<int16_t>(at),
                                                        disparities_[i], step};
    }
  }

  // Writes the disparities that have won to the map, and erases the others before segments are cut.
  HWY_INLINE void WriteWon(int u, hn::Mask<D16> wins, int16_t* counts) {
    const D16 d;
    const hn::Rebind<int8_t, D16> d8;
    int16_t* const disparities = disparities_.data() + kBeside + u;
    const V16 won = hn::IfThenElse(wins, hn::LoadU(d, disparities), hn::Set(d, ChoiceRow::kNone));
    hn::StoreU(won, d, disparities);
    static_assert(DisparityImage::kCountsPerPixel == 1 << 5);
    V16 values = hn::ShiftLeft<5>(won);
    if (rule_.sub_pixel) {
      values = hn::Add(values, hn::PromoteTo(d, hn::LoadU(d8, steps_.data() + kBeside + u)));
    }
    values = hn::IfThenElse(wins, values, hn::Set(d, DisparityImage::kInvalid));
    if (u + kLanes16 <= width_) {
      hn::StoreU(values, d, counts + u);
    } else {
      int16_t run[kLanes16];
      hn::StoreU(values, d, run);
      std::copy_n(run, width_ - u, counts + u);
    }
  }

  void Cut(int r) {
    const D16 d;
    const int16_t* const disparities = disparities_.data() + kBeside;
    const auto words = static_cast<int>(band_.words_per_row);
    auto* const bytes =
        reinterpret_cast<uint8_t*>(band_.cuts.data() + static_cast<size_t>(r * words));
    for (int u = 0; u < 64 * words; u += kLanes16) {
      const V16 step = hn::Sub(hn::LoadU(d, disparities + u), hn::LoadU(d, disparities + u - 1));
      hn::StoreMaskBits(d, hn::Gt(hn::Abs(step), hn::Set(d, 1)), bytes + u / 8);
    }
  }

  const GrowthRule& rule_;
  const GrowthInput& input_;
  SweepBand& band_;
  DisparityImage& map_;
  const int width_, height_;
  const size_t row_size_;
  int lost_count_ = 0;

  // Rows with kBeside entries before and behind them; priors and σ only behind.
  std::vector<int32_t> left_pairs_, right_pairs_;
  std::vector<int32_t> left_columns_, texture_columns_,
      right_columns_;  // Σ over columns of windows
  std::vector<int32_t> left_energies_, left_textures_, right_energies_;
  std::vector<int16_t> priors_;
  std::vector<uint8_t> sigmas_;
  std::vector<int16_t> disparities_, keys_;
  std::vector<int8_t> steps_;
  std::vector<int16_t> least_keys_;  // by right pixel
};

void SweepRows(const GrowthRule& rule, const GrowthInput& input, SweepBand& band,
               DisparityImage& map) {
  Sweep(rule, input, band, map).Run();
}

SweepFunction SweepOnTarget() { return SweepRows; }

#endif

}  // namespace HWY_NAMESPACE
}  // namespace sprout::grow
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sprout::grow {

HWY_EXPORT(SweepOnTarget);

SweepFunction FindSweep() { return HWY_DYNAMIC_DISPATCH(SweepOnTarget)(); }

}  // namespace sprout::grow
#endif  // HWY_ONCE
