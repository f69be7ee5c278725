#ifndef SPROUT_SERVICES_PRIOR_SEED_VOTES_H_
#define SPROUT_SERVICES_PRIOR_SEED_VOTES_H_

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "services/prior/delaunay.h"
#include "services/prior/seed_neighbours.h"
#include "services/prior/seed_surface.h"

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

  /// @param planes      of the seeds, one each.
  /// @param spacing_px  distance of seeds from one another, > 0.
  /// @param neighbours  of these seeds; must outlive the calls of Of().
  /// @param left_bgr    the image that they are in. O(seeds).
  void Look(std::span<const LocalPlane> planes, double spacing_px, const SeedNeighbours& neighbours,
            const cv::Mat3b& left_bgr);

  /// Votes of the neighbours of a triangle's seeds: each for the surface that its own plane is
  /// closer to at the pixel. Their weights fall exponentially with the difference of colours and
  /// with the distance; those whose planes meet neither surface have less of a say. Seeds that
  /// neighbour two of the triangle's, as these themselves do, count twice. About 0 where none is
  /// like the pixel.
  ///
  /// @param triangle   seeds that were looked at; others have no voice.
  /// @param pixel      in the left image, and its colour.
  /// @param near, far  disparities of the two surfaces there, counts.
  /// O(1), about 18 seeds, at most 48; thread-safe; the same on every machine.
  Votes Of(const SeedTriangle& triangle, cv::Point pixel, const cv::Vec3b& colour, int near,
           int far) const;

 private:
  struct SeedLook {
    int16_t u;
    int16_t v;
    cv::Vec3b colour;
    float counts;  // its disparity, and how that changes
    float counts_per_column;
    float counts_per_row;
  };

  const SeedNeighbours* neighbours_ = nullptr;
  float per_px_ = 0;  // steps of the table of distances
  std::vector<SeedLook> looks_;
  std::array<float, 3 * 255 + 1> likeness_{};
  std::array<float, 3 * 255 + 1> vague_likeness_{};
  std::array<float, 128> nearness_{};
};

}  // namespace sprout

#endif  // SPROUT_SERVICES_PRIOR_SEED_VOTES_H_
