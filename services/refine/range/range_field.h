#pragma once

#include <span>
#include <vector>

#include "services/refine/range/range_nodes.h"

namespace sprout::refine {

/// The error that the scene adds at a node, beside the curve, and how sure it is.
struct NodeOffset {
  double offset_px = 0;  ///< to add to the disparity, beside the curve's
  cv::Point2d slope;     ///< of the offset, px a px
  double sigma_px = 0;
  double likeness = 1;  ///< of the windows around the node at that offset, weighted by texture
  double texture = 0;  ///< mean variance of those windows, in the image that has less, grey levels²
};

/// What the scene adds to ranges, smooth on each surface, eqs. (R6) to (R9): labels by paths over
/// the nodes as in semi-global matching, then a membrane through the minima of their costs.
class RangeField {
 public:
  /// @param start_px  of each node, what its disparity is moved by before.
  /// @param least_share  of the texture; nothing is moved unless offsets are proved at more of it.
  ///                     1: none are searched, nodes are only judged.
  /// O(nodes · labels); no I/O; on OpenCV's threads, with the same result for any number.
  void Estimate(const RangeNodes& nodes, std::span<const double> start_px, double least_share);

  /// Looks again: offsets up to half a px are changed only where the first look was from afar.
  /// @param nodes  moved by start_px and the offsets, RangeNodes::Move().
  /// @pre variance_px2() > 0. Time as Estimate().
  void Improve(const RangeNodes& nodes);

  /// The offsets of the nodes.
  std::span<const NodeOffset> offsets() const { return offsets_; }
  /// Variance of the offsets, px²: what a point that no node speaks for may be off by.
  double variance_px2() const { return variance_px2_; }

 private:
  void SetCosts(const RangeNodes& nodes, std::span<const double> start_px);
  void Sum(const RangeNodes& nodes);
  void FindOffsets(const RangeNodes& nodes, double least_share);
  void OptimiseAgain(const RangeNodes& nodes);
  void SetSlopes(const RangeNodes& nodes);
  void Optimise(const RangeNodes& nodes, float moved);
  void AddPath(const RangeNodes& nodes, bool along_rows, bool back, float moved);
  struct Proved {
    double share = 0;   // of the texture
    double square = 0;  // mean square of its offsets, px², the others being 0
  };
  Proved KeepProved(const RangeNodes& nodes);
  void Choose();
  void Relax(const RangeNodes& nodes);
  void SetSigma(const RangeNodes& nodes);
  void Judge(const RangeNodes& nodes, std::span<const double> start_px);

  std::vector<OffsetCosts> data_;  // of the nodes
  std::vector<OffsetCosts> before_;
  std::vector<float> counts_;  // of the nodes that data_ sums up
  std::vector<float> counts_before_;
  std::vector<OffsetCosts> sums_;
  std::vector<NodeOffset> offsets_;
  double variance_px2_ = 0;
  Proved proved_;
  std::vector<size_t> labels_;
  std::vector<double> information_;  // of the nodes' own offsets, 1/px²
};

}  // namespace sprout::refine
