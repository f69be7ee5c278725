#ifndef SPROUT_SERVICES_PRIOR_SEED_VOTES_H_
#define SPROUT_SERVICES_PRIOR_SEED_VOTES_H_

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "common/core/seed.h"
#include "services/prior/delaunay.h"
#include "services/prior/seed_neighbours.h"

namespace sprout {

/// What the seeds around a pixel say about which of two surfaces it is on. Keeps its memory from
/// frame to frame, so one object serves one caller at a time.
class SeedVotes {
 public:
  /// 1 if all seeds that have a say are closer to the near surface, −1 if all are to the far one.
  struct Votes {
    double colour = 0;     ///< by seeds of the pixel's colour, wherever they are
    double proximity = 0;  ///< by seeds that are close to it, and of no other colour altogether
  };

  SeedVotes();

  /// @param spacing_px  distance of seeds from one another, > 0.
  /// @param neighbours  of these seeds; must outlive the calls of Of().
  /// @param left_bgr    the image that they are in. O(seeds).
  void Look(std::span<const Seed> seeds, double spacing_px, const SeedNeighbours& neighbours,
            const cv::Mat3b& left_bgr);

  /// Votes of the neighbours of a triangle's seeds, with weights that fall exponentially with the
  /// difference of colours and with the distance. Seeds that neighbour two of the triangle's, as
  /// these themselves do, count twice. About 0 where none is like the pixel.
  ///
  /// @param triangle       seeds that were looked at; others have no voice.
  /// @param pixel          in the left image, and its colour.
  /// @param near_plus_far  sum of the disparities of the two surfaces, counts.
  /// O(1), about 18 seeds, at most 48; thread-safe; whole numbers until the last step.
  Votes Of(const SeedTriangle& triangle, cv::Point pixel, const cv::Vec3b& colour,
           int near_plus_far) const;

 private:
  struct SeedLook {
    int16_t u;
    int16_t v;
    cv::Vec3b colour;
    int twice_counts;  // its disparity
  };

  const SeedNeighbours* neighbours_ = nullptr;
  float per_px_ = 0;  // steps of the table of distances
  std::vector<SeedLook> looks_;
  std::array<int, 3 * 255 + 1> likeness_{};
  std::array<int, 3 * 255 + 1> vague_likeness_{};
  std::array<int, 128> nearness_{};
};

}  // namespace sprout

#endif  // SPROUT_SERVICES_PRIOR_SEED_VOTES_H_
