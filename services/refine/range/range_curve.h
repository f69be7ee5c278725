#pragma once

#include <span>
#include <vector>

#include "common/core/rig.h"
#include "services/refine/range/range_nodes.h"

namespace sprout::refine {

/// A knot of a range sensor's systematic error b(z), which is linear between knots.
struct RangeKnot {
  double depth_m = 0;  ///< as measured
  double error_m = 0;  ///< measured less true
  double sigma_m = 0;  ///< standard deviation of error_m; infinite when nothing shows it
};

/// What all points of a frame are off by, as a function of their depth, eq. (R5). Nodes vote for
/// errors in metres; the curve through the votes that costs least is taken if it is significant.
class RangeCurve {
 public:
  /// @param stiff  for points that are far apart, such as a lidar's, whose error hardly changes
  ///               with the depth: a significant curve is drawn neither to 0 nor from knot to
  ///               knot, as long as it stays about as significant.
  /// O(nodes · candidates); no I/O; on OpenCV's threads, with the same result for any number.
  void Estimate(std::span<const RangeNode> nodes, const RectifiedPair& pair, bool stiff);

  /// Bounds the standard deviation of a knot by that of another one and what the errors at both
  /// depths may differ by, so that one without texture is about as sure as its neighbours.
  /// @param error_m  the most that the device is off by, over RangeRules::kAlikeOverM. O(knots²).
  void BoundSigmas(double error_m);

  /// The knots, sorted by depth; empty when too few nodes show anything.
  std::span<const RangeKnot> knots() const { return knots_; }
  bool is_zero() const { return is_zero_; }

  /// Whether the nodes prefer depths as measured to depths that are all off by ±error_m, or this is
  /// a part of a px only. Of the last Estimate(). O(nodes).
  bool IsShownRight(std::span<const RangeNode> nodes, const RectifiedPair& pair,
                    double error_m) const;

  /// What a disparity has to be moved by, px.
  double OffsetPx(const RectifiedPair& pair, double disparity) const;
  /// Standard deviation of that, px.
  double SigmaPx(const RectifiedPair& pair, double disparity) const;

 private:
  struct Voter {
    double depth_m = 0;
    size_t node = 0;
  };
  struct Bin;
  struct Penalties;

  void Vote(std::span<const RangeNode> nodes, const RectifiedPair& pair, Bin& bin) const;
  void FindPath(std::span<const Bin> bins, const Penalties& penalties);
  void Stiffen(std::span<const RangeNode> nodes, const RectifiedPair& pair,
               std::span<const Bin> bins);
  double BestFactor(std::span<const RangeNode> nodes, const RectifiedPair& pair, int power) const;
  void TryScale(std::span<const RangeNode> nodes, const RectifiedPair& pair);
  double GainInSigmas(std::span<const RangeNode> nodes, const RectifiedPair& pair) const;
  template <typename ErrorAt, typename OtherAt>
  double GainInSigmas(std::span<const RangeNode> nodes, const RectifiedPair& pair,
                      const ErrorAt& error_at, const OtherAt& other_at) const;
  void SetSigmas(std::span<const RangeNode> nodes, const RectifiedPair& pair,
                 std::span<const Bin> bins);
  RangeKnot At(double depth_m) const;

  std::vector<Voter> voters_;  // by depth
  cv::Size blocks_;            // of the range image
  double step_m_ = 0;          // between candidates
  std::vector<RangeKnot> knots_;
  bool is_zero_ = true;
};

/// A node's cost at an offset, px, between labels by a parabola.
double CostAt(const OffsetCosts& costs, double offset_px);

}  // namespace sprout::refine
