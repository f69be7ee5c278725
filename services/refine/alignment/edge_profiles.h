#ifndef SPROUT_SERVICES_REFINE_ALIGNMENT_EDGE_PROFILES_H_
#define SPROUT_SERVICES_REFINE_ALIGNMENT_EDGE_PROFILES_H_

#include <cmath>
#include <cstddef>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "services/refine/alignment/tof_edges.h"

namespace sprout::refine {

/// How far EdgeProfiles looks, px of the images.
struct ProfileSizes {
  int reach = 0;        ///< farthest place on either side of where an edge should be; > 0
  int window = 0;       ///< pixels on either side of a place that are averaged; > 0
  double plane_px = 0;  ///< how far surfaces are extrapolated with their slopes
};

/// Where a pair of images shows depth edges: for each edge and each place along its normal the
/// evidence, eq. (A4), that the edge lies there. Keeps its memory, 4 bytes a place of an edge.
class EdgeProfiles {
 public:
  /// @param left, right  rectified pair, grey, of one size.
  /// @param edges        in px of these images, inside the left one.
  /// O(edges · (reach + window)), about 20 ns each. On OpenCV's threads, with the same result for
  /// any number.
  void Set(const cv::Mat1b& left, const cv::Mat1b& right, std::span<const TofEdge> edges,
           const ProfileSizes& sizes);

  /// Evidence that edge `k` lies `place` px along its normal, rounded: up to 1.5; 0 beyond the
  /// reach.
  float At(size_t k, double place) const {
    return std::abs(place) <= reach_ ? Value(k, cvRound(place)) : 0;
  }

  /// The evidence of At() between the pixels, linear.
  double Between(size_t k, double place) const;

 private:
  float Value(size_t k, int place) const {
    if (place > reach_) return 0;
    return profiles_[k * places_ + static_cast<size_t>(place + reach_)];
  }

  int reach_ = 0;
  size_t places_ = 0;
  std::vector<float> profiles_;
};

}  // namespace sprout::refine

#endif  // SPROUT_SERVICES_REFINE_ALIGNMENT_EDGE_PROFILES_H_
