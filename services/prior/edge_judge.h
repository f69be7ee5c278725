#ifndef SPROUT_SERVICES_PRIOR_EDGE_JUDGE_H_
#define SPROUT_SERVICES_PRIOR_EDGE_JUDGE_H_

#include <cstdint>
#include <opencv2/core.hpp>

#include "services/prior/seed_votes.h"

namespace sprout {

/// A pixel of the left image that lies on one of two surfaces.
struct EdgePixel {
  int u;
  int v;
  int near;  ///< its disparity on one of them, counts
  int far;   ///< on the other; 0 ≤ far ≤ near
};

/// What votes of 1 count for; that of the images' differences counts for 1.
struct EdgeWeights {
  double census = 0;
  double colour = 0;
  double proximity = 0;
};

/// What the choice between two disparities of a pixel rests on.
struct EdgeEvidence {
  cv::Mat3b left_bgr;
  cv::Mat1b left_grey;  ///< the pair that is matched
  cv::Mat1b right_grey;
  cv::Mat1b left_census;  ///< CensusTransform() of that
  cv::Mat1b right_census;
  const SeedVotes* seeds;  ///< not null
  EdgeWeights weights;
};

/// Decides between two disparities of a pixel of the left image. Witnesses vote, each with −1 (far)
/// to 1 (near), and the sum of their weighted votes decides:
///   the images, by the mean absolute difference, truncated, in a window of 3×3 pixels;
///   the images, by the mean Hamming distance of their census transforms in a window of 7×7, where
///   half of the bits is a vote of 1;
///   the seeds around, by their colour and by their proximity (SeedVotes).
class EdgeJudge {
 public:
  /// @param evidence  must outlive the judge.
  explicit EdgeJudge(const EdgeEvidence& evidence) : evidence_(evidence) {}

  /// Whether a pixel is rather near than far.
  /// @param edge  which of those that the evidence's seeds were looked at for: the pixel's.
  /// The same answer on every machine. O(1), about a thousand operations; thread-safe.
  bool IsNear(const EdgePixel& pixel, int edge) const;

 private:
  // Sums over windows: how much worse far is than near.
  struct Costs {
    int differences = 0;
    int census = 0;
  };

  int rows() const { return evidence_.left_grey.rows; }
  int columns() const { return evidence_.left_grey.cols; }
  Costs Inside(int u, int v, int near_px, int far_px) const;
  Costs AtBorder(int u, int v, int near_px, int far_px) const;
  int Difference(cv::Point left, int disparity_px) const;
  int CensusDistance(cv::Point left, int disparity_px) const;

  const EdgeEvidence& evidence_;
};

}  // namespace sprout

#endif  // SPROUT_SERVICES_PRIOR_EDGE_JUDGE_H_
