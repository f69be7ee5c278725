// Compiled by Highway once for each instruction set; one of them is picked when the program runs.
#include "services/refine/range/range_costs.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

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
constexpr int kEighths = 8;

struct OffsetSums {
  int64_t left = 0, left_squares = 0;
  std::array<int32_t, kLabels> right{}, right_squares{}, products{};
};

// A window around a pixel, and its disparity at the smallest offset, in units of 1/256 px.
struct OffsetWindow {
  const cv::Mat1b& left;
  const cv::Mat1b& right;
  cv::Point at;
  int disparity, slope_u, slope_v;
};

}  // namespace
}  // namespace sprout::refine
#endif  // once

HWY_BEFORE_NAMESPACE();
namespace sprout::refine {
namespace HWY_NAMESPACE {

using LabelInts = int32_t __attribute__((vector_size(4 * kLabels)));
using LabelBytes = uint8_t __attribute__((vector_size(kLabels)));

// Not returned: how a vector of 64 bytes is differs between instruction sets.
HWY_INLINE void LoadLabels(const uint8_t* from, LabelInts& to) {
  LabelBytes bytes;
  std::memcpy(&bytes, from, sizeof bytes);
  to = __builtin_convertvector(bytes, LabelInts);
}

// One lane an offset: for a pixel of the window, offsets lie in consecutive pixels of the right
// image, the largest one first.
bool SumOffsetsOnTarget(const OffsetWindow& window, OffsetSums& to) {
  LabelInts right_sum{}, right_squares{}, products{}, before, behind;
  for (int y = -kCostRadius; y <= kCostRadius; ++y) {
    const uint8_t* left = window.left[window.at.y + y] + window.at.x;
    const uint8_t* right = window.right[window.at.y + y];
    for (int x = -kCostRadius; x <= kCostRadius; ++x) {
      const int disparity = window.disparity + window.slope_u * x + window.slope_v * y;
      const int column = (window.at.x + x) * kCostFine - disparity;
      const int first = (column >> 8) - (kLabels - 1);
      if (first < 0 || first + kLabels >= window.right.cols) return false;
      const int part = (column & (kCostFine - 1)) / (kCostFine / kEighths);
      LoadLabels(right + first, before);
      LoadLabels(right + first + 1, behind);
      const LabelInts grey = before * (kEighths - part) + behind * part;
      const int32_t own = left[x] * kEighths;
      to.left += own;
      to.left_squares += own * own;
      right_sum += grey;
      right_squares += grey * grey;
      products += grey * own;
    }
  }
  std::memcpy(to.right.data(), &right_sum, sizeof right_sum);
  std::memcpy(to.right_squares.data(), &right_squares, sizeof right_squares);
  std::memcpy(to.products.data(), &products, sizeof products);
  return true;
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

std::optional<OffsetCosts> CostsOf(const cv::Mat1b& left, const cv::Mat1b& right,
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
  OffsetSums sums;
  if (!HWY_DYNAMIC_DISPATCH(SumOffsetsOnTarget)(window, sums)) return {};
  // Of all pixels, in grey levels squared.
  constexpr double kUnit = double{kEighths} * kEighths * kCostPixels * kCostPixels;
  const auto variance = [](int64_t sum, int64_t squares) {
    return static_cast<float>(static_cast<double>(kCostPixels * squares - sum * sum) / kUnit);
  };
  OffsetCosts costs;
  costs.left_variance = variance(sums.left, sums.left_squares);
  for (size_t k = 0; k < kLabels; ++k) {
    const size_t lane = kLabels - 1 - k;  // the largest offset comes first
    const int64_t sum = sums.right[lane];
    costs.right_variance[k] = variance(sum, sums.right_squares[lane]);
    costs.covariance[k] = static_cast<float>(
        static_cast<double>(kCostPixels * int64_t{sums.products[lane]} - sum * sums.left) / kUnit);
    // Eq. (R12).
    const float likeness =
        2 * costs.covariance[k] /
        (costs.left_variance + costs.right_variance[k] + 2 * RangeRules::kNoiseVariance);
    costs.cost[k] = 1 - std::clamp(likeness, RangeRules::kLeastLikeness, 1.0F);
  }
  return costs;
}

}  // namespace sprout::refine
#endif  // HWY_ONCE
