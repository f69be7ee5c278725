// Compiled by Highway once for each instruction set; one of them is picked when the program runs.
#include "services/refine/range/range_costs.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "services/refine/range/range_costs.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef SPROUT_SERVICES_REFINE_RANGE_COSTS_SHARED_
#define SPROUT_SERVICES_REFINE_RANGE_COSTS_SHARED_
namespace sprout::refine {
namespace {

constexpr int kLabels = RangeRules::kLabels;
constexpr int kCostRadius = RangeRules::kWindowRadius;
constexpr int kCostPixels = (2 * kCostRadius + 1) * (2 * kCostRadius + 1);
// Disparities in 1/256 px; the right image between two pixels in steps of an eighth.
constexpr int kCostFine = 256;
constexpr int kEighthsBits = 3;
constexpr int kEighths = 1 << kEighthsBits;

// Sums over the right window at each offset, and of the products with the left one.
struct OffsetSums {
  std::array<int32_t, kLabels> right, right_squares, products;
};

// A window around a pixel, and its disparity at the smallest offset, in units of 1/256 px.
struct OffsetWindow {
  const cv::Mat1b& left;
  const cv::Mat1b& right;
  cv::Point at;
  int disparity, slope_u, slope_v;

  // Where a pixel of the window lies in the right image, in 1/256 px.
  int ColumnOf(int x, int y) const {
    return (at.x + x) * kCostFine - (disparity + slope_u * x + slope_v * y);
  }
  // Whether that is in the image at all offsets: if it is in the corners.
  bool IsInside() const {
    for (const int y : {-kCostRadius, kCostRadius}) {
      for (const int x : {-kCostRadius, kCostRadius}) {
        const int first = (ColumnOf(x, y) >> 8) - (kLabels - 1);
        if (first < 0 || first + kLabels >= right.cols) return false;
      }
    }
    return true;
  }
};

}  // namespace
}  // namespace sprout::refine
#endif  // once

HWY_BEFORE_NAMESPACE();
namespace sprout::refine {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using LabelInts = hn::CappedTag<int32_t, kLabels / 2>;
using LabelBytes = hn::Rebind<uint8_t, LabelInts>;
using LabelVector = hn::Vec<LabelInts>;

HWY_INLINE LabelVector LoadLabels(const uint8_t* from) {
  return hn::PromoteTo(LabelInts(), hn::LoadU(LabelBytes(), from));
}

// Sums over the window for the offsets of one vector.
struct VectorSums {
  LabelVector right, right_squares, products;
};

HWY_INLINE void Clear(VectorSums& sums) {
  sums.right = sums.right_squares = sums.products = hn::Zero(LabelInts());
}

// Adds a pixel: `part` eighths of the way from one column of the right image to the next.
HWY_INLINE void Add(const uint8_t* column, LabelVector part, LabelVector own, VectorSums& sums) {
  const LabelVector before = LoadLabels(column);
  const LabelVector grey = hn::Add(hn::ShiftLeft<kEighthsBits>(before),
                                   hn::Mul(hn::Sub(LoadLabels(column + 1), before), part));
  sums.right = hn::Add(sums.right, grey);
  sums.right_squares = hn::Add(sums.right_squares, hn::Mul(grey, grey));
  sums.products = hn::Add(sums.products, hn::Mul(grey, own));
}

HWY_INLINE void Store(const VectorSums& sums, size_t lane, OffsetSums& to) {
  hn::StoreU(sums.right, LabelInts(), to.right.data() + lane);
  hn::StoreU(sums.right_squares, LabelInts(), to.right_squares.data() + lane);
  hn::StoreU(sums.products, LabelInts(), to.products.data() + lane);
}

// One lane an offset: for a pixel of the window, offsets lie in consecutive pixels of the right
// image, the largest one first. Two vectors at a time.
// @pre the window lies in both images at all offsets.
void SumOffsetsOnTarget(const OffsetWindow& window, OffsetSums& to) {
  const LabelInts d;
  const size_t lanes = hn::Lanes(d);
  for (size_t lane = 0; lane < kLabels; lane += 2 * lanes) {
    VectorSums one, other;
    Clear(one);
    Clear(other);
    for (int y = -kCostRadius; y <= kCostRadius; ++y) {
      const uint8_t* left = window.left[window.at.y + y] + window.at.x;
      const uint8_t* right = window.right[window.at.y + y] - (kLabels - 1) + lane;
      for (int x = -kCostRadius; x <= kCostRadius; ++x) {
        const int column = window.ColumnOf(x, y);
        const uint8_t* at = right + (column >> 8);
        const LabelVector part = hn::Set(d, (column & (kCostFine - 1)) / (kCostFine / kEighths));
        const LabelVector own = hn::Set(d, left[x] * kEighths);
        Add(at, part, own, one);
        Add(at + lanes, part, own, other);
      }
    }
    Store(one, lane, to);
    Store(other, lane + lanes, to);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace sprout::refine
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sprout::refine {
namespace {

HWY_EXPORT(SumOffsetsOnTarget);
static_assert(kCostFine == 1 << 8);
// Sums of squares have 32 bits.
static_assert(int64_t{255} * kEighths * 255 * kEighths * kCostPixels < (int64_t{1} << 31));

}  // namespace

OffsetCosts CostsOf(const OffsetMoments& moments, double noise) {
  OffsetCosts costs;
  for (size_t k = 0; k < kLabels; ++k) {
    const float likeness =
        2 * moments.covariance[k] /
        (moments.left_variance + moments.right_variance[k] + 2 * static_cast<float>(noise));
    costs[k] = 1 - std::clamp(likeness, RangeRules::kMinLikeness, 1.0F);
  }
  return costs;
}

std::optional<OffsetMoments> MomentsOf(const cv::Mat1b& left, const cv::Mat1b& right,
                                       const SlantedPatch& patch) {
  const cv::Point at(static_cast<int>(std::lround(patch.at.x)),
                     static_cast<int>(std::lround(patch.at.y)));
  const cv::Rect inside(kCostRadius, kCostRadius, left.cols - 2 * kCostRadius,
                        left.rows - 2 * kCostRadius);
  if (!inside.contains(at) || std::abs(patch.slope.x) > RangeRules::kSteepest ||
      std::abs(patch.slope.y) > RangeRules::kSteepest)
    return {};
  const auto fine = [](double px) { return static_cast<int>(std::lround(px * kCostFine)); };
  const double beside = patch.slope.x * (at.x - patch.at.x) + patch.slope.y * (at.y - patch.at.y);
  const OffsetWindow window{left,
                            right,
                            at,
                            fine(patch.disparity_px + beside + RangeRules::OffsetPx(0)),
                            fine(patch.slope.x),
                            fine(patch.slope.y)};
  if (!window.IsInside()) return {};
  OffsetSums sums;
  HWY_DYNAMIC_DISPATCH(SumOffsetsOnTarget)(window, sums);
  int64_t left_sum = 0;
  int64_t left_squares = 0;
  for (int y = -kCostRadius; y <= kCostRadius; ++y) {
    const uint8_t* row = left[at.y + y] + at.x;
    for (int x = -kCostRadius; x <= kCostRadius; ++x) {
      const int32_t own = row[x] * kEighths;
      left_sum += own;
      left_squares += own * own;
    }
  }
  // Divisor that turns a sum over all pixels into grey levels squared.
  constexpr double kUnit = double{kEighths} * kEighths * kCostPixels * kCostPixels;
  const auto variance = [](int64_t sum, int64_t squares) {
    return static_cast<float>(static_cast<double>(kCostPixels * squares - sum * sum) / kUnit);
  };
  OffsetMoments moments;
  moments.left_variance = variance(left_sum, left_squares);
  for (size_t k = 0; k < kLabels; ++k) {
    const size_t lane = kLabels - 1 - k;  // the largest offset comes first
    const int64_t sum = sums.right[lane];
    moments.right_variance[k] = variance(sum, sums.right_squares[lane]);
    moments.covariance[k] = static_cast<float>(
        static_cast<double>(kCostPixels * int64_t{sums.products[lane]} - sum * left_sum) / kUnit);
  }
  return moments;
}

bool IsAlike(const cv::Mat1b& left, const cv::Mat1b& right, const Seed& match, double noise) {
  const auto moments = MomentsOf(
      left, right, {.at = {match.u, match.v}, .disparity_px = match.disparity(), .slope = {}});
  if (!moments) return false;
  const OffsetCosts costs = CostsOf(*moments, noise);
  const auto* const here = costs.begin() + RangeRules::kZeroLabel;
  return *std::min_element(here - 1, here + 2) < 1 - RangeRules::kContradicted;
}

}  // namespace sprout::refine
#endif  // HWY_ONCE
