// The tables of a band: pairs of pixels, window energies, what is open to growth. Compiled once for
// each instruction set, like growth.cc.
#include <algorithm>

#include "services/grow/growth_band.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "services/grow/growth_tables.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

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

// The pairs of a band from the first row of its first windows on. Rows outside the image are in no
// window; any row will do.
void FillPairs(const cv::Mat1b& image, const GrowthBand& band, int32_t* pairs) {
  const auto row = [&](int v) { return image[std::clamp(v, 0, image.rows - 1)]; };
  for (int r = 0; r < GrowthBand::PairRows(band.rows()); ++r, pairs += band.stride()) {
    const int v = band.first_row() - kWindowRadius + r;
    StorePairs(row(v), row(v + 1), static_cast<size_t>(image.cols), pairs);
  }
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

// Puts energies and priors (null: none, all pixels are open) into the pixels of a row.
void FillRow(const int32_t* energies, const int16_t* priors, int width, LeftPixel* pixels) {
  const int end = width - kWindowRadius;
  const auto sweep = [&](auto d, int u) HWY_ATTR {
    const hn::Rebind<int16_t, decltype(d)> d16;
    for (const int lanes = static_cast<int>(hn::MaxLanes(d)); u + lanes <= end; u += lanes) {
      auto prior = hn::Zero(d);
      if (priors != nullptr) prior = hn::PromoteTo(d, hn::LoadU(d16, priors + u));
      const auto closed = hn::Eq(prior, hn::Set(d, DisparityImage::kInvalid));
      const auto disparity =
          hn::IfThenElse(closed, hn::Set(d, LeftPixel::kClosed), hn::Set(d, LeftPixel::kFree));
      LeftPixels<decltype(d)>(hn::LoadU(d, energies + u), prior, disparity).Store(pixels + u);
    }
    return u;
  };
  const int rest = sweep(hn::CappedTag<int32_t, GrowthBand::kRunPixels>(), kWindowRadius);
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
    FillRow(energies, prior, width, row.left);
  });
  fill(input.right, [&](const GrowthRow& row, int) HWY_ATTR {
    SumWindows<kWithSums>(columns, width, row.right_energy, row.right_sum);
  });
}

void PrepareOnTarget(const GrowthInput& input, const GrowthRule& rule, GrowthBand& band) {
  FillPairs(input.left, band, band.row(0).left_pairs[0]);
  FillPairs(input.right, band, band.row(0).right_pairs[0]);
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
