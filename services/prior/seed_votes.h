#ifndef SPROUT_SERVICES_PRIOR_SEED_VOTES_H_
#define SPROUT_SERVICES_PRIOR_SEED_VOTES_H_

#include <array>
#include <cstddef>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "services/prior/edge_triangles.h"
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

  /// @param edges       whose nearby seeds will be asked.
  /// @param planes      of the seeds.
  /// @param spacing_px  distance of seeds from one another, > 0.
  /// @param left_bgr    the image that they are in.
  /// O(edges), about a kilobyte each; on OpenCV's threads.
  void Look(std::span<const EdgeTriangle> edges, std::span<const LocalPlane> planes,
            double spacing_px, const cv::Mat3b& left_bgr);

  /// Votes of the seeds around a triangle: each for the surface that its own plane is closer to at
  /// the pixel. Their weights fall with the difference of colours and with the distance; those
  /// whose planes meet neither surface have less of a say. About 0 where none is like the pixel.
  ///
  /// @param edge       which of those that were looked at.
  /// @param pixel      in the left image, and its colour.
  /// @param near, far  disparities of the two surfaces there, counts.
  /// O(1); thread-safe; the same on every machine.
  Votes Of(int edge, cv::Point pixel, const cv::Vec3b& colour, int near, int far) const;

 private:
  static constexpr size_t kLanes = 4;
  using Lanes = std::array<float, kLanes>;

  // Some seeds, side by side for the machine's vectors.
  struct Looks {
    Lanes u;
    Lanes v;
    Lanes counts;  // disparities, and how these change
    Lanes per_column;
    Lanes per_row;
    Lanes blue;
    Lanes green;
    Lanes red;
  };
  static_assert(EdgeTriangle::kMostSeeds % kLanes == 0);
  using LooksAround = std::array<Looks, EdgeTriangle::kMostSeeds / kLanes>;

  struct Edge {
    size_t looks = 0;  // that have seeds
    LooksAround around;
  };

  static void LookAt(const LocalPlane& plane, const cv::Mat3b& left_bgr, size_t lane, Looks& looks);

  float nearness_per_px2_ = 0;
  std::vector<Edge> edges_;
};

}  // namespace sprout

#endif  // SPROUT_SERVICES_PRIOR_SEED_VOTES_H_
