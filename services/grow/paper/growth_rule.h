#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <opencv2/core.hpp>

#include "common/config/config.h"
#include "common/core/disparity_image.h"
#include "common/core/prior_map.h"

// What the plain and the fast implementation of growth share: their input, the units in which they
// compute, and the rules where the paper leaves a choice.
namespace sprout::grow {

/// Side of the correlation window, px (n = 5 in the paper).
inline constexpr int kWindow = 5;
inline constexpr int kWindowRadius = kWindow / 2;

/// Similarities are compared as costs: −ln of eqs. (4) to (6), or 1 − MNCC, in whole
/// steps of 2⁻²⁰ rounded down, so that comparisons are the same on every machine. 20 bits of 24 in
/// a float leave room for costs above 1.
inline constexpr int32_t kCostUnit = 1 << 20;

/// Larger costs are cut to this one: 8 units, beyond every limit, −ln 0.001 = 6.9 units; and a
/// whole number that fits into the 23 bits of a float's fraction.
inline constexpr float kMaxCost = (1 << 23) - 1;

/// Cost of a disparity whose window does not fit: above all others, with two bits to spare for the
/// rank of a disparity.
inline constexpr int32_t kExcludedCost = (1 << 29) - 1;

/// Largest step from a whole disparity, counts: half a pixel less one, so that rounding a disparity
/// leads back to the whole one (WholeDisparity()).
inline constexpr int kMaxStep = DisparityImage::kCountsPerPixel / 2 - 1;

/// Counts of a matched pixel rounded to whole pixels.
inline int WholeDisparity(int counts) {
  static_assert(DisparityImage::kCountsPerPixel == 1 << 5);
  return (counts + DisparityImage::kCountsPerPixel / 2) >> 5;
}

/// Levels of the queue of seeds. With 64, results were up to 0.4 points worse (NOTES.md).
inline constexpr int kLevels = 256;

/// Keys by which claims on a right pixel are compared in a sweep: costs up to the limit with their
/// lowest bits cut off, so that twice a key, and one more, fit into 15 bits.
inline constexpr int kKeys = (1 << 14) - 1;

/// Pixels to which the prior leaves disparities so far from its own, px, are open. Below, where
/// there are up to 15 candidates, the best of all is as good as one that growth leads to, and found
/// in a fraction of the time; with 8 px it is not (NOTES.md).
inline constexpr int kSweptPx = 7;

/// Pixels of a row that the fast sweep looks at together, at most.
inline constexpr int kRunPixels = 16;

/// Rows of the bands in which an image grows; the last may have fewer. At most 64, and as even as
/// possible, so that neither of two threads has a whole band more to do than the other.
inline int RowsPerBand(int height) {
  constexpr int kMaxRows = 64;
  const int bands = (height + kMaxRows - 1) / kMaxRows;
  return (height + bands - 1) / bands;
}
inline int CountBands(int height) {
  return (height + RowsPerBand(height) - 1) / RowsPerBand(height);
}

/// Left pixel (u, v) and right pixel (u − d, v).
struct Correspondence {
  int u, v, d;
};

/// Whether both 5×5 windows lie in images of that size. d < 0, and what a map cannot hold, fits
/// nothing.
inline bool WindowsFit(const Correspondence& q, cv::Size size) {
  constexpr int kRadius = kWindowRadius;
  return q.d >= 0 && q.d <= DisparityImage::kMaxWholePx && q.u - q.d >= kRadius &&
         q.u < size.width - kRadius && q.v >= kRadius && q.v < size.height - kRadius;
}

/// One pair of images, grey, and its prior, which is used only if the similarity is EPC.
struct GrowthInput {
  const cv::Mat1b& left;
  const cv::Mat1b& right;
  const PriorMap& prior;
};

/// What decides on a correspondence: the configuration, converted to the units in which growth
/// computes.
struct GrowthRule {
  GrowConfig::Similarity similarity = GrowConfig::EPC;
  bool sub_pixel = false;
  int32_t limit = 0;            ///< largest accepted cost: −ln τ, with MNCC 1 − τ
  int32_t levels_per_cost = 0;  ///< in fixed point, see LevelOf()
  float photo_scale = 0;        ///< kCostUnit / σ_s² of eq. (4); kCostUnit with MNCC

  /// By the counts of the prior's standard deviation, PriorMap::sigma: kCostUnit / (2·σ_p²) of
  /// eq. (5), σ_p in counts of DisparityImage; and the distance, counts, beyond which eq. (5) alone
  /// is above the limit.
  std::array<float, kMaxSigmaCounts + 1> prior_scales{};
  std::array<int, kMaxSigmaCounts + 1> prior_reaches{};

  /// Smallest standard deviation, counts, of a pixel to which the prior leaves more than the two
  /// whole disparities on either side of it; for smaller ones σ_p is sigma_p_px.
  int min_wide_sigma = 0;

  /// Smallest standard deviation, counts, of an open pixel: one to which the prior leaves
  /// disparities that are kSweptPx or more from its own. kMaxSigmaCounts + 1: no pixel is open. 0:
  /// every pixel is, without a prior or where sigma_p_px alone leaves so many (preset paper).
  int min_open_sigma = 0;
  bool IsOpen(uint8_t sigma) const { return sigma >= min_open_sigma; }

  /// A cost's key, 0 to kKeys − 1. @param cost  not above the limit.
  int32_t KeyOf(int32_t cost) const { return cost >> key_shift; }
  int key_shift = 0;

  /// A cost's level in the queue of seeds, 0 to kLevels − 1: levels between 0 and the limit have
  /// equal widths; costs above the limit share the last one (S3). 22 fractional bits are the most
  /// for which no product exceeds 31 bits: cost · levels_per_cost ≤ kLevels << 22.
  static constexpr int kLevelFraction = 22;
  int LevelOf(int32_t cost) const {
    return std::min(cost, limit) * levels_per_cost >> kLevelFraction;
  }
};

/// @param config  with values in range.
GrowthRule MakeGrowthRule(const GrowConfig& config);

/// σ_p of eq. (5) at a pixel, px: what the configuration makes of the prior's standard deviation σ
/// there,
///   σ_p = max(sigma_p_px, sigma_p_noise · √(max(0, σ² − sigma_p_sure_px²))).      (S1)
double SigmaP(const GrowConfig& config, double sigma_px);

}  // namespace sprout::grow
