// Compiled by Highway once for each instruction set; one of them is picked when the program runs.
#include "services/refine/stereo/patch_matcher.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "services/refine/stereo/patch_matcher.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef SPROUT_SERVICES_REFINE_PATCH_MATCHER_SHARED_
#define SPROUT_SERVICES_REFINE_PATCH_MATCHER_SHARED_
namespace sprout::refine {
namespace {

// The window: 4 pixels before and 3 behind a pixel, along either side. Its middle needs to be on no
// pixel, since the patch has a slope.
constexpr int kBefore = 4;
constexpr int kSide = 2 * kBefore;
constexpr int kPixels = kSide * kSide;

// Disparities in whole numbers: 1/256 px on the patch, 1/32 px for what a pixel is off.
constexpr int kFine = 256;
constexpr int kFinePerStep = 8;
constexpr int kSteps = kFine / kFinePerStep;

// Steepest slope, px a px: so that no sum has more than 32 bits.
constexpr double kSteepest = 0.4;

// The window around a pixel, and its disparity, in units of 1/256 px.
struct PatchWindow {
  const cv::Mat1b& left;
  const cv::Mat1b& right;
  cv::Point at;
  int disparity, slope_u, slope_v;
};

// Over the window: g four times the slope of grey, half of it from either image, ρ the difference
// of grey values that the patch leaves, times 128.
struct PatchSums {
  int64_t g = 0, rho = 0, g_rho = 0, g_g = 0;
};

}  // namespace
}  // namespace sprout::refine
#endif  // once

HWY_BEFORE_NAMESPACE();
namespace sprout::refine {
namespace HWY_NAMESPACE {

using FourInts = int32_t __attribute__((vector_size(16)));

HWY_INLINE FourInts LoadFourGreys(const uint8_t* from) {
  using FourBytes = uint8_t __attribute__((vector_size(4)));
  FourBytes bytes;
  std::memcpy(&bytes, from, sizeof bytes);
  return __builtin_convertvector(bytes, FourInts);
}

HWY_INLINE int64_t Total(FourInts x) { return int64_t{x[0]} + x[1] + x[2] + x[3]; }

// @pre the window and a pixel more to either side lie in both images.
bool SumPatchOnTarget(const PatchWindow& window, PatchSums& to) {
  FourInts g_sum{}, rho_sum{}, g_rho_sum{}, g_g_sum{};
  for (int y = -kBefore; y < kBefore; ++y) {
    const int of_row = window.disparity + window.slope_v * y;
    const int whole = of_row >> 8;
    const int part = (of_row & (kFine - 1)) / kFinePerStep;
    const int first = window.at.x - whole - kBefore;
    if (first < 2 || first + kSide >= window.right.cols) return false;
    const uint8_t* left = window.left[window.at.y + y] + window.at.x - kBefore;
    const uint8_t* right = window.right[window.at.y + y] + first;
    HWY_UNROLL(2)
    for (int i = 0; i < kSide; i += 4) {
      // Between two pixels of the right image, times 32.
      const FourInts before = LoadFourGreys(right + i - 1);
      const FourInts at = LoadFourGreys(right + i) * (kSteps - part) + before * part;
      const FourInts rise = (LoadFourGreys(right + i + 1) - before) * (kSteps - part) +
                            (LoadFourGreys(right + i) - LoadFourGreys(right + i - 2)) * part;
      const FourInts g =
          LoadFourGreys(left + i + 1) - LoadFourGreys(left + i - 1) + ((rise + kSteps / 2) >> 5);
      // What the slope along the row adds.
      const FourInts x = FourInts{0, 1, 2, 3} + (i - kBefore);
      const FourInts rest = (x * window.slope_u + kFinePerStep / 2) >> 3;
      const FourInts rho = LoadFourGreys(left + i) * (4 * kSteps) - at * 4 + g * rest;
      g_sum += g;
      rho_sum += rho;
      g_rho_sum += g * rho;
      g_g_sum += g * g;
    }
  }
  to = {Total(g_sum), Total(rho_sum), Total(g_rho_sum), Total(g_g_sum)};
  return true;
}

}  // namespace HWY_NAMESPACE
}  // namespace sprout::refine
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sprout::refine {
namespace {

HWY_EXPORT(SumPatchOnTarget);
static_assert(kFine == 1 << 8 && kFinePerStep == 1 << 3 && kSteps == 1 << 5);

// A step of Gauss and Newton, px: least squares over the window, with grey values less their means.
std::optional<double> StepOf(const PatchWindow& window) {
  PatchSums sums;
  if (!HWY_DYNAMIC_DISPATCH(SumPatchOnTarget)(window, sums)) return {};
  const int64_t g_g = kPixels * sums.g_g - sums.g * sums.g;
  const int64_t g_rho = kPixels * sums.g_rho - sums.g * sums.rho;
  if (g_g <= 0) return {};
  return -static_cast<double>(g_rho) / static_cast<double>(g_g) / kSteps;
}

}  // namespace

std::optional<double> MatchPatch(const cv::Mat1b& left, const cv::Mat1b& right,
                                 const SlantedPatch& patch, double most_shift_px) {
  constexpr int kRounds = 2;
  constexpr double kSmallStepPx = 0.25;  // within it images are linear: a second one gains nothing
  const cv::Point at(static_cast<int>(std::lround(patch.at.x)),
                     static_cast<int>(std::lround(patch.at.y)));
  const cv::Rect inside(kBefore + 1, kBefore, left.cols - kSide - 1, left.rows - kSide + 1);
  if (!inside.contains(at) || std::abs(patch.slope.x) > kSteepest ||
      std::abs(patch.slope.y) > kSteepest)
    return {};
  const auto fine = [](double px) { return static_cast<int>(std::lround(px * kFine)); };
  // How the disparity changes from the patch's own place to that pixel.
  const double beside = patch.slope.x * (at.x - patch.at.x) + patch.slope.y * (at.y - patch.at.y);
  const double start = patch.disparity_px + beside;
  PatchWindow window{left, right, at, 0, fine(patch.slope.x), fine(patch.slope.y)};
  double disparity_px = start;
  for (int round = 0; round < kRounds; ++round) {
    window.disparity = fine(disparity_px);
    const std::optional<double> step = StepOf(window);
    if (!step) return {};
    disparity_px = std::clamp(window.disparity / double{kFine} + *step, start - most_shift_px,
                              start + most_shift_px);
    if (std::abs(*step) < kSmallStepPx) break;
  }
  return disparity_px - beside;
}

}  // namespace sprout::refine
#endif  // HWY_ONCE
