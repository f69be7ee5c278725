// Compiled by Highway once for each instruction set; one of them is picked when the program runs.
#include "services/prior/edges/data_term_kernel.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>

#include "common/core/disparity_image.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "services/prior/edges/data_term_kernel.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace sprout::prior {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, ColourSeeds::kAtOnce>;
using V = hn::Vec<D>;

HWY_INLINE V Square(V x) { return hn::Mul(x, x); }

// Added up by fours whatever the registers' width: sums of floats depend on the order.
HWY_INLINE float SumByFours(const float* numbers, size_t count) {
  float sums[4] = {};
  for (size_t i = 0; i < count; i += 4) {
    for (size_t k = 0; k < 4; ++k) sums[k] += numbers[i + k];
  }
  return sums[0] + sums[1] + sums[2] + sums[3];
}

// A pixel and its labels for eq. (P7).
struct ColourPixel {
  float u, v;
  float blue, green, red;
  float middle, half_gap;  // of the labels, counts
};

// Eq. (P7), C_colour(far) − C_colour(near): the support of near less that of far, over all support.
HWY_INLINE double ColourTerm(const ColourSeeds& seeds, const DataTermScales& scales,
                             const ColourPixel& pixel) {
  // Weight of a seed whose colour is three ranges off: where all are, colours hardly tell.
  constexpr float kNoSupport = 0.01F;
  const D d;
  const V one = hn::Set(d, 1.0F);
  alignas(64) ColourSeeds::Numbers support, near_support;  // near less far
  const auto off = [&](float value, const ColourSeeds::Numbers& numbers, size_t i)
                       HWY_ATTR { return hn::Sub(hn::Set(d, value), hn::LoadU(d, &numbers[i])); };
  for (size_t i = 0; i < seeds.count; i += hn::MaxLanes(d)) {
    const V along_row = hn::Mul(hn::LoadU(d, &seeds.per_column[i]), off(pixel.u, seeds.u, i));
    const V along_column = hn::Mul(hn::LoadU(d, &seeds.per_row[i]), off(pixel.v, seeds.v, i));
    const V at_pixel = hn::Add(hn::Add(hn::LoadU(d, &seeds.counts[i]), along_row), along_column);
    const V above = hn::Sub(at_pixel, hn::Set(d, pixel.middle));
    const V difference = hn::Add(
        hn::Add(hn::Abs(off(pixel.blue, seeds.blue, i)), hn::Abs(off(pixel.green, seeds.green, i))),
        hn::Abs(off(pixel.red, seeds.red, i)));
    // Half the weight for planes that miss both labels by edge_px.
    const V miss =
        hn::Mul(hn::Sub(hn::Abs(above), hn::Set(d, pixel.half_gap)), hn::Set(d, scales.per_miss));
    const V unlike = hn::Add(one, Square(hn::Mul(difference, hn::Set(d, scales.per_range))));
    const V weight = hn::Div(one, hn::Mul(hn::Add(one, Square(miss)), Square(unlike)));
    hn::StoreU(weight, d, &support[i]);
    hn::StoreU(hn::CopySign(weight, above), d, &near_support[i]);
  }
  return double{SumByFours(near_support.data(), seeds.count)} /
         (kNoSupport + SumByFours(support.data(), seeds.count));
}

constexpr int kRadius = 1;        // of the window of grey differences, px: sharp at edges
constexpr int kCensusRadius = 3;  // of that of the census; a row of it fits into 64 bits
constexpr int kWindow = (2 * kRadius + 1) * (2 * kRadius + 1);
constexpr int kCensusSide = 2 * kCensusRadius + 1;
constexpr int kCensusWindow = kCensusSide * kCensusSide;
constexpr int kUnlikeBits = 4;  // unlike pixels differ in half of the 8 bits of their codes

// Counts to whole pixels.
HWY_INLINE int Rounded(int counts) {
  constexpr int kOne = DisparityImage::kCountsPerPixel;
  return (counts + kOne / 2) / kOne;
}

using CensusWindow = std::array<uint64_t, kCensusSide>;  // rows of codes

HWY_INLINE CensusWindow ReadCensus(const cv::Mat1b& codes, int u, int v) {
  CensusWindow window{};
  for (int y = 0; y < kCensusSide; ++y) {
    std::memcpy(&window[static_cast<size_t>(y)], codes[v - kCensusRadius + y] + u - kCensusRadius,
                kCensusSide);
  }
  return window;
}

// Adds three numbers of one bit in each of 64 places.
struct BitSum {
  HWY_INLINE BitSum(uint64_t a, uint64_t b, uint64_t c)
      : ones(a ^ b ^ c), twos((a & b) | (c & (a ^ b))) {}
  uint64_t ones;
  uint64_t twos;
};

// Bits in which windows differ. Adds the seven rows up place by place first: counting bits is slow.
HWY_INLINE int HammingDistance(const CensusWindow& a, const CensusWindow& b) {
  const auto row = [&](size_t y) HWY_ATTR { return a[y] ^ b[y]; };
  const BitSum upper(row(0), row(1), row(2));
  const BitSum lower(row(3), row(4), row(5));
  const BitSum all(upper.ones, lower.ones, row(6));
  const BitSum carried(upper.twos, lower.twos, all.twos);
  return std::popcount(all.ones) + 2 * std::popcount(carried.ones) +
         4 * std::popcount(carried.twos);
}

// Eq. (P6): C_grey and C_census. Both are equal for near and far where a window leaves an image.
HWY_INLINE double ImageTerms(const EdgeImages& images, const DataTermScales& scales,
                             const LabelledPixel& pixel) {
  const auto& [u, v, near, far] = pixel;
  const int near_px = Rounded(near);
  const int far_px = Rounded(far);
  const cv::Mat1b &left_grey = images.left_grey, &right_grey = images.right_grey;
  if (u - near_px < kCensusRadius || u + kCensusRadius >= left_grey.cols || v < kCensusRadius ||
      v + kCensusRadius >= left_grey.rows) {
    return 0;
  }
  const int truncation = scales.grey_truncation;
  int grey = 0;
  for (int y = v - kRadius; y <= v + kRadius; ++y) {
    const uint8_t* const left = left_grey[y] + u;
    const uint8_t* const at_near = right_grey[y] + u - near_px;
    const uint8_t* const at_far = right_grey[y] + u - far_px;
    for (int x = -kRadius; x <= kRadius; ++x) {
      grey += std::min(std::abs(left[x] - at_far[x]), truncation) -
              std::min(std::abs(left[x] - at_near[x]), truncation);
    }
  }
  const CensusWindow left = ReadCensus(images.left_census, u, v);
  const int bits = HammingDistance(left, ReadCensus(images.right_census, u - far_px, v)) -
                   HammingDistance(left, ReadCensus(images.right_census, u - near_px, v));
  return static_cast<double>(grey) / (kWindow * truncation) +
         scales.census_weight * bits / (kCensusWindow * kUnlikeBits);
}

}  // namespace

double FarMinusNearOnTarget(const EdgeImages& images, const ColourSeeds& seeds,
                            const DataTermScales& scales, const LabelledPixel& pixel) {
  const double image_term = ImageTerms(images, scales, pixel);
  // (P7) is within ±1: such images are not outvoted.
  if (std::abs(image_term) >= scales.colour_weight) return image_term;
  const cv::Vec3b& bgr = images.left_bgr[pixel.v][pixel.u];
  const double colour_term =
      ColourTerm(seeds, scales,
                 {.u = static_cast<float>(pixel.u),
                  .v = static_cast<float>(pixel.v),
                  .blue = static_cast<float>(bgr[0]),
                  .green = static_cast<float>(bgr[1]),
                  .red = static_cast<float>(bgr[2]),
                  .middle = 0.5F * static_cast<float>(pixel.near + pixel.far),
                  .half_gap = 0.5F * static_cast<float>(pixel.near - pixel.far)});
  return image_term + scales.colour_weight * colour_term;
}

}  // namespace HWY_NAMESPACE
}  // namespace sprout::prior
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sprout::prior {

HWY_EXPORT(FarMinusNearOnTarget);

DataTermScales::DataTermScales(const PriorConfig& config)
    : census_weight(config.census_weight()),
      colour_weight(config.colour_weight()),
      grey_truncation(config.grey_truncation()),
      per_miss(static_cast<float>(1 / (DisparityImage::kCountsPerPixel * config.edge_px()))),
      per_range(static_cast<float>(1 / config.colour_range())) {}

double FarMinusNear(const EdgeImages& images, const ColourSeeds& seeds,
                    const DataTermScales& scales, const LabelledPixel& pixel) {
  return HWY_DYNAMIC_DISPATCH(FarMinusNearOnTarget)(images, seeds, scales, pixel);
}

}  // namespace sprout::prior
#endif  // HWY_ONCE
