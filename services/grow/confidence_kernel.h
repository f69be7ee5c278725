#ifndef SPROUT_SERVICES_GROW_CONFIDENCE_KERNEL_H_
#define SPROUT_SERVICES_GROW_CONFIDENCE_KERNEL_H_

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "common/core/disparity_image.h"

// The terms of formula C1 (confidence.h) in vectors; the same bytes on every CPU.
namespace sprout::grow {

/// Penalties are whole numbers of 2⁻¹⁶.
inline constexpr int kFullPenalty = 1 << 16;
inline constexpr int kEdgeWeight = kFullPenalty * 45 / 100;
inline constexpr int kGapWeight = kFullPenalty * 15 / 100;
inline constexpr int kPhotoWeight = kFullPenalty * 15 / 100;
inline constexpr int kHoleWeight = kFullPenalty * 25 / 100;

inline constexpr int kLargestExponent = 5;  // exp(−5) < 0.01: no similarity
inline constexpr int kGapWindow = 9;        // as far as a gap's 5×5 median looks, and as far again
inline constexpr float kUsualSpacings = 0.75F;  // to the next seed
inline constexpr int kPhotoWindow = 5;          // as growth's

/// kGapWeight · gaps / 81 rounded down is gaps · kGapFactor / 2¹⁶ rounded down.
inline constexpr int kGapFactor = kGapWeight * (1 << 16) / (kGapWindow * kGapWindow) + 1;
static_assert([] {
  for (int gaps = 0; gaps <= kGapWindow * kGapWindow; ++gaps) {
    if (gaps * kGapFactor >> 16 != kGapWeight * gaps / (kGapWindow * kGapWindow)) return false;
  }
  return true;
}());

/// Penalties of distances to depth edges by quarters of a pixel; the last one for all beyond.
using EdgePenalties = std::array<int32_t, 256>;

/// Rows of distances that are kept between calls.
struct DistanceMemory {
  std::vector<int32_t> kept_rows;  ///< every 32nd row of the pass from the top
  std::vector<int32_t> rows;       ///< 32 of them, and two of the pass from the bottom
};

/// Penalty for the distance to the next depth edge (more than 1 px within 3×3 pixels) of each
/// pixel. Distances are those of cv::distanceTransform with DIST_L2 and a 3×3 mask, to the last
/// bit. O(pixels).
void PenaliseEdges(const DisparityImage& filled, const EdgePenalties& by_distance,
                   DistanceMemory& memory, cv::Mat1w& penalties);

/// The same for the distance to the next seed.
/// @param no_seed  0 where a seed is. @param spacing_px  of seeds spread evenly.
void PenaliseHoles(const cv::Mat1b& no_seed, float spacing_px, DistanceMemory& memory,
                   cv::Mat1w& penalties);

/// What the confidence depends on, besides the two penalties.
struct ConfidenceInput {
  const cv::Mat1b& left;
  const cv::Mat1b& right;
  const DisparityImage& grown;
  const DisparityImage& filled;
  const cv::Mat1w& edge_penalties;
  const cv::Mat1w& hole_penalties;
  float photo_scale;  ///< 1 / σ_s²
};

/// Writes the rows of the confidence. O(pixels).
void RateRows(const ConfidenceInput& input, const cv::Range& rows, cv::Mat1b& confidence);

}  // namespace sprout::grow

#endif  // SPROUT_SERVICES_GROW_CONFIDENCE_KERNEL_H_
