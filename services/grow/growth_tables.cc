// The tables of a band: columns, window energies, what is open to growth. Compiled once for each
// instruction set, like growth.cc.
#include <algorithm>
#include <array>

#include "services/grow/growth_band.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "services/grow/growth_tables.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace sprout {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

constexpr int kColumn = GrowthBand::kColumnRows;
using RowPointers = std::array<const uint8_t*, kColumn>;

#if HWY_TARGET != HWY_SCALAR
// Columns of eight rows from column u on, eight at once: an 8×8 transpose.
HWY_INLINE void StoreEightColumns(const RowPointers& rows, size_t u, int16_t* columns) {
  const hn::FixedTag<uint8_t, 16> d8;
  const hn::FixedTag<uint8_t, 8> d_half;
  const hn::FixedTag<int16_t, 8> d16;
  const auto row = [&](size_t i) HWY_ATTR {
    return hn::ZeroExtendVector(d8, hn::LoadU(d_half, rows[i] + u));
  };
  const auto lower = [&](auto a, auto b) HWY_ATTR { return hn::InterleaveLower(d8, a, b); };
  const auto upper = [&](auto a, auto b) HWY_ATTR { return hn::InterleaveUpper(d8, a, b); };
  const auto r04 = lower(row(0), row(4)), r15 = lower(row(1), row(5));
  const auto r26 = lower(row(2), row(6)), r37 = lower(row(3), row(7));
  const auto store_two = [&](auto two, int16_t* to) HWY_ATTR {
    const auto zero = hn::Zero(d8);
    hn::StoreU(hn::BitCast(d16, lower(two, zero)), d16, to);
    hn::StoreU(hn::BitCast(d16, upper(two, zero)), d16, to + kColumn);
  };
  const auto store_four = [&](auto even_rows, auto odd_rows, int16_t* to) HWY_ATTR {
    store_two(lower(even_rows, odd_rows), to);
    store_two(upper(even_rows, odd_rows), to + 2 * kColumn);
  };
  store_four(lower(r04, r26), lower(r15, r37), columns);
  store_four(upper(r04, r26), upper(r15, r37), columns + 4 * kColumn);
}

#endif

void StoreColumns(const RowPointers& rows, size_t width, int16_t* columns) {
  size_t u = 0;
#if HWY_TARGET != HWY_SCALAR
  for (; u + kColumn <= width; u += kColumn) {
    StoreEightColumns(rows, u, columns + u * kColumn);
  }
#endif
  for (; u < width; ++u) {
    for (size_t i = 0; i < kColumn; ++i) columns[u * kColumn + i] = rows[i][u];
  }
}

// The set of columns for the band's row `row` and the three behind it. Rows outside the image are
// in no window; any row will do.
void FillColumns(const cv::Mat1b& image, int first_row, int16_t* columns) {
  RowPointers rows;
  for (int i = 0; i < kColumn; ++i) {
    rows[static_cast<size_t>(i)] =
        image[std::clamp(first_row - kWindowRadius + i, 0, image.rows - 1)];
  }
  StoreColumns(rows, static_cast<size_t>(image.cols), columns);
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

// Column sums over the five rows around `row`. @param first  nothing is in `sums` yet.
template <bool kSquares>
void MoveColumnSums(const cv::Mat1b& image, int row, bool first, int32_t* sums) {
  const auto width = static_cast<size_t>(image.cols);
  if (!first) {
    return UpdateColumnSums<kSquares>(image[row + kWindowRadius], image[row - kWindowRadius - 1],
                                      width, sums);
  }
  std::fill_n(sums, width, 0);
  for (int y = row - kWindowRadius; y <= row + kWindowRadius; ++y) {
    UpdateColumnSums<kSquares>(image[y], nullptr, width, sums);
  }
}

// Sum of five neighbours in a row of column sums.
HWY_INLINE int32_t FiveAround(const int32_t* sums, int u) {
  return sums[u - 2] + sums[u - 1] + sums[u] + sums[u + 1] + sums[u + 2];
}

// Σ w² of the window, or n²·var with MNCC (then Σ w goes to `window_sum`).
template <bool kWithSums>
HWY_INLINE int32_t EnergyAt(const int32_t* squares, const int32_t* plain, int u,
                            uint16_t* window_sum) {
  const int32_t energy = FiveAround(squares, u);
  if constexpr (!kWithSums) return energy;
  const int32_t sum = FiveAround(plain, u);
  window_sum[u] = static_cast<uint16_t>(sum);
  return kWindow * kWindow * energy - sum * sum;
}

template <bool kWithSums>
void FillEnergies(const GrowthInput& input, bool with_prior, GrowthBand& band) {
  const int width = band.width();
  const int height = band.image_size().height;
  int32_t* squares = band.column_sums.data();
  int32_t* plain = squares + width;
  const auto fill = [&](const cv::Mat1b& image, const auto& store_row) HWY_ATTR {
    bool first = true;
    for (int r = 0; r < band.rows(); ++r) {
      const int v = band.first_row() + r;
      if (v < kWindowRadius || v >= height - kWindowRadius) continue;
      MoveColumnSums<true>(image, v, first, squares);
      if constexpr (kWithSums) MoveColumnSums<false>(image, v, first, plain);
      first = false;
      store_row(r, v);
    }
  };
  fill(input.left, [&](int r, int v) HWY_ATTR {
    const GrowthRow& row = band.row(r);
    auto* sums = row.left_sum;
    const int16_t* prior = with_prior ? input.prior.counts()[v] : nullptr;
    for (int u = kWindowRadius; u < width - kWindowRadius; ++u) {
      LeftPixel& pixel = row.left[u];
      pixel.energy = EnergyAt<kWithSums>(squares, plain, u, sums);
      pixel.prior = with_prior ? prior[u] : int16_t{0};
      const bool open = !with_prior || prior[u] != DisparityImage::kInvalid;
      pixel.disparity = open ? LeftPixel::kFree : LeftPixel::kClosed;
    }
  });
  fill(input.right, [&](int r, int) HWY_ATTR {
    const GrowthRow& row = band.row(r);
    auto* sums = row.right_sum;
    auto* energy = row.right_energy;
    for (int u = kWindowRadius; u < width - kWindowRadius; ++u) {
      energy[u] = EnergyAt<kWithSums>(squares, plain, u, sums);
    }
  });
}

void PrepareOnTarget(const GrowthInput& input, const GrowthRule& rule, GrowthBand& band) {
  for (int r = 0; r < band.rows(); r += GrowthBand::kRowsPerSet) {
    const GrowthRow& row = band.row(r);
    FillColumns(input.left, band.first_row() + r, row.left_columns);
    FillColumns(input.right, band.first_row() + r, row.right_columns);
  }
  if (rule.similarity == GrowConfig::MNCC) {
    FillEnergies<true>(input, false, band);
  } else {
    FillEnergies<false>(input, rule.similarity == GrowConfig::EPC, band);
  }
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
  HWY_DYNAMIC_DISPATCH(PrepareOnTarget)(input, rule, band);
}

}  // namespace sprout
#endif  // HWY_ONCE
