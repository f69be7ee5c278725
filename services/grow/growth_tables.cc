// The tables of a band: pairs of pixels, window energies, what is open to growth. Compiled once for
// each instruction set, like growth.cc.
#include <algorithm>

#include "services/grow/growth_band.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "services/grow/growth_tables.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "services/grow/candidates-inl.h"
#include "services/grow/left_pixels-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sprout {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Pairs of the pixels of two rows, one above the other.
void StorePairs(const uint8_t* upper, const uint8_t* lower, size_t width, int32_t* pairs) {
  const auto sweep = [&](auto d, size_t u) HWY_ATTR {
    const hn::Rebind<uint8_t, decltype(d)> d8;
    for (const size_t lanes = hn::Lanes(d); u + lanes <= width; u += lanes) {
      const auto one = hn::PromoteTo(d, hn::LoadU(d8, upper + u));
      const auto other = hn::PromoteTo(d, hn::LoadU(d8, lower + u));
      hn::StoreU(hn::Or(one, hn::ShiftLeft<16>(other)), d, pairs + u);
    }
    return u;
  };
  const size_t rest = sweep(hn::ScalableTag<int32_t>(), 0);
  sweep(hn::CappedTag<int32_t, 1>(), rest);
}

// A row of a band's pairs, counted from the first row of its first windows. Rows outside the image
// are in no window; any row will do.
void FillPairs(const cv::Mat1b& image, const GrowthBand& band, int pair_row, int32_t* pairs) {
  const auto row = [&](int v) { return image[std::clamp(v, 0, image.rows - 1)]; };
  const int v = band.first_row() - kWindowRadius + pair_row;
  StorePairs(row(v), row(v + 1), static_cast<size_t>(image.cols), pairs);
}

// sums[u] += Σ of `added` − Σ of `removed` (which may be null), squared or not.
template <bool kSquares>
void UpdateColumnSums(const uint8_t* added, const uint8_t* removed, size_t width, int32_t* sums) {
  const hn::ScalableTag<int32_t> d;
  const hn::Rebind<uint8_t, decltype(d)> d8;
  const size_t lanes = hn::Lanes(d);
  const auto value = [&](const uint8_t* pixels, size_t u) HWY_ATTR {
    const auto v = hn::PromoteTo(d, hn::LoadU(d8, pixels + u));
    if constexpr (kSquares) {
      return hn::Mul(v, v);
    } else {
      return v;
    }
  };
  size_t u = 0;
  for (; u + lanes <= width; u += lanes) {
    auto sum = hn::Add(hn::LoadU(d, sums + u), value(added, u));
    if (removed != nullptr) sum = hn::Sub(sum, value(removed, u));
    hn::StoreU(sum, d, sums + u);
  }
  for (; u < width; ++u) {
    sums[u] += kSquares ? added[u] * added[u] : added[u];
    if (removed != nullptr) sums[u] -= kSquares ? removed[u] * removed[u] : removed[u];
  }
}

// Column sums of one row and one image.
struct ColumnSums {
  int32_t* squares;
  int32_t* plain;  // only with MNCC
};

// Moves sums over five rows to those around row v. @param first  nothing is in `sums` yet.
template <bool kSquares>
void MoveTo(int v, bool first, const cv::Mat1b& image, int32_t* sums) {
  const auto width = static_cast<size_t>(image.cols);
  if (!first) {
    return UpdateColumnSums<kSquares>(image[v + kWindowRadius], image[v - kWindowRadius - 1], width,
                                      sums);
  }
  std::fill_n(sums, width, 0);
  for (int y = v - kWindowRadius; y <= v + kWindowRadius; ++y) {
    UpdateColumnSums<kSquares>(image[y], nullptr, width, sums);
  }
}

// Σ w² of the windows in a row, or n²·var with MNCC (then Σ w goes to `window_sums`).
template <bool kWithSums>
void SumWindows(const ColumnSums& columns, int width, int32_t* energies, uint16_t* window_sums) {
  const int end = width - kWindowRadius;
  const auto sweep = [&](auto d, int u) HWY_ATTR {
    const hn::Rebind<uint16_t, decltype(d)> d16;
    const auto five_around = [&](const int32_t* sums) HWY_ATTR {
      const auto two = hn::Add(hn::LoadU(d, sums - 2), hn::LoadU(d, sums - 1));
      const auto three = hn::Add(two, hn::LoadU(d, sums));
      return hn::Add(three, hn::Add(hn::LoadU(d, sums + 1), hn::LoadU(d, sums + 2)));
    };
    for (const int lanes = static_cast<int>(hn::Lanes(d)); u + lanes <= end; u += lanes) {
      auto energy = five_around(columns.squares + u);
      if constexpr (kWithSums) {
        const auto sum = five_around(columns.plain + u);
        hn::StoreU(hn::DemoteTo(d16, sum), d16, window_sums + u);
        energy = hn::Sub(hn::Mul(hn::Set(d, kWindow * kWindow), energy), hn::Mul(sum, sum));
      }
      hn::StoreU(energy, d, energies + u);
    }
    return u;
  };
  const int rest = sweep(hn::ScalableTag<int32_t>(), kWindowRadius);
  sweep(hn::CappedTag<int32_t, 1>(), rest);
}

// Puts priors (null: none, all pixels are open) into the pixels of a row.
void FillRow(const int16_t* priors, int width, LeftPixel* pixels) {
  const int end = width - kWindowRadius;
  const auto sweep = [&](auto d, int u) HWY_ATTR {
    const hn::Rebind<int16_t, decltype(d)> d16;
    for (const int lanes = static_cast<int>(hn::MaxLanes(d)); u + lanes <= end; u += lanes) {
      auto prior = hn::Zero(d);
      if (priors != nullptr) prior = hn::PromoteTo(d, hn::LoadU(d16, priors + u));
      const auto closed = hn::Eq(prior, hn::Set(d, DisparityImage::kInvalid));
      const auto disparity =
          hn::IfThenElse(closed, hn::Set(d, LeftPixel::kClosed), hn::Set(d, LeftPixel::kFree));
      LeftPixels<decltype(d)>(hn::Zero(d), prior, disparity).Store(pixels + u);
    }
    return u;
  };
  const int rest = sweep(hn::CappedTag<int32_t, GrowthBand::kRunPixels>(), kWindowRadius);
  sweep(hn::CappedTag<int32_t, 1>(), rest);
}

// The tables of a band, row by row.
template <bool kWithSums>
class Tables {
 public:
  Tables(const GrowthInput& input, const GrowthRule& rule, GrowthBand& band)
      : input_(input),
        rule_(rule),
        band_(band),
        left_columns_{band.row_scratch(0), band.row_scratch(1)},
        right_columns_{band.row_scratch(2), band.row_scratch(3)} {}

  void Fill() {
    constexpr int kFirstPairs = 2 * kWindowRadius;
    for (int pair_row = 0; pair_row < kFirstPairs; ++pair_row) FillPairRow(pair_row);
    bool first = true;
    for (int r = 0; r < band_.rows(); ++r) {
      FillPairRow(r + kFirstPairs);
      const int v = band_.first_row() + r;
      if (v < kWindowRadius || v >= band_.image_size().height - kWindowRadius) continue;
      MoveColumnsTo(v, first, input_.left, left_columns_);
      MoveColumnsTo(v, first, input_.right, right_columns_);
      first = false;
      FillPixels(band_.row(r), v);
    }
  }

 private:
  void FillPairRow(int pair_row) {
    FillPairs(input_.left, band_, pair_row, band_.LeftPairs(pair_row));
    FillPairs(input_.right, band_, pair_row, band_.RightPairs(pair_row));
  }

  static void MoveColumnsTo(int v, bool first, const cv::Mat1b& image, const ColumnSums& columns) {
    MoveTo<true>(v, first, image, columns.squares);
    if constexpr (kWithSums) MoveTo<false>(v, first, image, columns.plain);
  }

  void FillPixels(const GrowthRow& row, int v) {
    const int width = band_.width();
    SumWindows<kWithSums>(right_columns_, width, row.right_energy, row.right_sum);
    SumWindows<kWithSums>(left_columns_, width, row.left_energy, row.left_sum);
    const bool with_prior = rule_.similarity == GrowConfig::EPC;
    const int16_t* const priors = with_prior ? input_.prior.disparity.counts()[v] : nullptr;
    if (band_.kind() == GrowthBand::Kind::kOpen) return FillRow(priors, width, row.left);
    FillCandidates(priors, row);
    if (band_.kind() == GrowthBand::Kind::kMixed) OpenUnsure(priors, row);
  }

  // Where the prior leaves more than two candidates.
  void OpenUnsure(const int16_t* priors, const GrowthRow& row) const {
    for (int u = kWindowRadius; u < band_.width() - kWindowRadius; ++u) {
      if (row.sigma[u] < rule_.least_open || priors[u] == DisparityImage::kInvalid) continue;
      row.left[u].candidates = Candidates(1U << Candidates::kOpen);
      row.left[u].disparity = LeftPixel::kFree;
    }
  }

  void FillCandidates(const int16_t* priors, const GrowthRow& row) {
    std::copy_n(priors, band_.width(), band_.prior_scratch());
    const auto fill = [&](auto sweep) HWY_ATTR {
      sweep.Fill(row, band_.prior_scratch(), kWindowRadius, band_.width() - kWindowRadius);
    };
    rule_.sub_pixel ? fill(CandidateSweep<true>(rule_, band_.queue))
                    : fill(CandidateSweep<false>(rule_, band_.queue));
  }

  const GrowthInput& input_;
  const GrowthRule& rule_;
  GrowthBand& band_;
  ColumnSums left_columns_;
  ColumnSums right_columns_;
};

void PrepareOnTarget(const GrowthInput& input, const GrowthRule& rule, GrowthBand& band) {
  if (rule.similarity == GrowConfig::MNCC) return Tables<true>(input, rule, band).Fill();
  Tables<false>(input, rule, band).Fill();
}

}  // namespace HWY_NAMESPACE
}  // namespace sprout
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sprout {

HWY_EXPORT(PrepareOnTarget);

void PrepareBand(const GrowthInput& input, const GrowthRule& rule, GrowthBand& band) {
  band.queue.Reset(rule.limit);
  band.changed = false;
  std::fill(band.right_matched.begin(), band.right_matched.end(), uint8_t{0});
  if (rule.similarity == GrowConfig::EPC) band.SetSigma(input.prior.sigma);
  HWY_DYNAMIC_DISPATCH(PrepareOnTarget)(input, rule, band);
}

}  // namespace sprout
#endif  // HWY_ONCE
