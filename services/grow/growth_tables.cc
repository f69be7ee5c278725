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

// Column sums of one row.
struct ColumnSums {
  int32_t* squares;
  int32_t* plain;  // only with MNCC
};

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

template <bool kWithSums>
void FillEnergies(const GrowthInput& input, bool with_prior, GrowthBand& band) {
  const int width = band.width();
  const int height = band.image_size().height;
  const ColumnSums columns{band.row_scratch.data(), band.row_scratch.data() + width};
  const auto fill = [&](const cv::Mat1b& image, const auto& fill_row) HWY_ATTR {
    bool first = true;
    for (int r = 0; r < band.rows(); ++r) {
      const int v = band.first_row() + r;
      if (v < kWindowRadius || v >= height - kWindowRadius) continue;
      MoveColumnSums<true>(image, v, first, columns.squares);
      if constexpr (kWithSums) MoveColumnSums<false>(image, v, first, columns.plain);
      first = false;
      fill_row(band.row(r), v);
    }
  };
  int32_t* const energies = band.row_scratch.data() + 2 * width;
  fill(input.left, [&](const GrowthRow& row, int v) HWY_ATTR {
    SumWindows<kWithSums>(columns, width, energies, row.left_sum);
    const int16_t* prior = with_prior ? input.prior.counts()[v] : nullptr;
    for (int u = kWindowRadius; u < width - kWindowRadius; ++u) {
      const int16_t prior_counts = with_prior ? prior[u] : int16_t{0};
      const bool open = prior_counts != DisparityImage::kInvalid;
      LeftPixel& pixel = row.left[u];
      pixel.energy = energies[u];
      pixel.prior = prior_counts;
      pixel.disparity = open ? LeftPixel::kFree : LeftPixel::kClosed;
    }
  });
  fill(input.right, [&](const GrowthRow& row, int) HWY_ATTR {
    SumWindows<kWithSums>(columns, width, row.right_energy, row.right_sum);
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
