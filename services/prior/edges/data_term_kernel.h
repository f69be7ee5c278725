#pragma once

#include <array>
#include <cstddef>
#include <opencv2/core.hpp>

#include "common/config/config.h"

namespace sprout::prior {

/// The seeds around a triangle across a depth edge, as arrays for vector instructions: planes, in
/// counts instead of px, and the left image's colour at the seed. The arrays are padded to a
/// multiple of kAtOnce with copies of the last seed whose colour differs from every other colour.
struct ColourSeeds {
  static constexpr size_t kMaxSeeds = 32;
  static constexpr size_t kAtOnce = 16;  ///< most numbers in a register
  using Numbers = std::array<float, kMaxSeeds>;

  Numbers u, v, counts, per_column, per_row, blue, green, red;
  size_t count = 0;  ///< seeds that are summed: a multiple of four
};

/// What the data term compares.
struct EdgeImages {
  cv::Mat3b left_bgr;
  cv::Mat1b left_grey;  ///< the pair that is matched
  cv::Mat1b right_grey;
  cv::Mat1b left_census;  ///< CensusTransform() of these
  cv::Mat1b right_census;
};

/// Weights and scales of eqs. (P6) and (P7).
struct DataTermScales {
  explicit DataTermScales(const PriorConfig& config);

  double census_weight, colour_weight;
  int grey_truncation;
  float per_miss;   ///< of a plane that misses both labels, a count
  float per_range;  ///< of differences in colour
};

/// A pixel with two labels, counts.
struct LabelledPixel {
  int u, v;
  int near, far;
};

/// Eq. (P6), E(far) − E(near); without the colours, which cost most, where they cannot change its
/// sign. The same on every CPU.
double FarMinusNear(const EdgeImages& images, const ColourSeeds& seeds,
                    const DataTermScales& scales, const LabelledPixel& pixel);

}  // namespace sprout::prior
