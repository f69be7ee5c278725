#ifndef SPROUT_SERVICES_PRIOR_COLOUR_KERNEL_H_
#define SPROUT_SERVICES_PRIOR_COLOUR_KERNEL_H_

#include <array>
#include <cstddef>

namespace sprout::prior {

/// The seeds around a triangle across a depth edge, as arrays for vector instructions: planes, in
/// counts instead of px, and the left image's colour at the seed. The arrays are padded to a
/// multiple of kAtOnce with copies of the last seed whose colour differs from every other colour.
struct ColourSeeds {
  static constexpr size_t kMost = 32;
  static constexpr size_t kAtOnce = 16;  ///< most numbers in a register
  using Numbers = std::array<float, kMost>;

  Numbers u, v, counts, per_column, per_row, blue, green, red;
  size_t count = 0;  ///< seeds that are summed: a multiple of four
};

/// A pixel with two labels, and the scales of eq. (P7).
struct ColourPixel {
  float u, v;
  float blue, green, red;
  float middle, half_gap;  ///< of the labels, counts
  float per_miss;          ///< of a plane that misses both, a count
  float per_range;         ///< of differences in colour
};

/// Eq. (P7), C_colour(far) − C_colour(near): the support of near minus that of far, divided by all
/// support. The same on every CPU.
double ColourTerm(const ColourSeeds& seeds, const ColourPixel& pixel);

}  // namespace sprout::prior

#endif  // SPROUT_SERVICES_PRIOR_COLOUR_KERNEL_H_
