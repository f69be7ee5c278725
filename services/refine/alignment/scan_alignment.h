#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <span>
#include <string>
#include <vector>

#include "common/core/rig.h"
#include "common/geometry/projection.h"
#include "services/refine/range/range_curve.h"
#include "services/refine/range/range_nodes.h"

namespace sprout::refine {

/// Where a lidar's scan fits the pair better than where it is projected.
struct ScanMove {
  double du_px = 0;  ///< to be added in the left image: the lidar is turned, or the rig turns
  double dv_px = 0;
  double roll_rad = 0;      ///< about the optical axis of the left camera, clockwise > 0
  double nearer_m = 0;      ///< to be taken off the depths z: the rig moved forward since the scan
  double significance = 0;  ///< what the images gain by the move, in standard deviations
  bool is_off = false;      ///< the move is sure

  bool operator==(const ScanMove&) const = default;
};

/// Measures in one frame how far a lidar's scan is off: turned against its calibration, or of
/// another moment than the pair. TofAligner needs edges; a scan has too few points to show them,
/// but whether the images agree with a point can be asked of each. Keeps its memory from frame to
/// frame; one object serves one caller at a time.
class ScanAligner {
 public:
  /// @param points  those of input.surface.
  /// @param start_px  null, or where stereo shows that they belong, to be added in the left image:
  ///                  the search starts there, and always.
  /// @returns a move that is not off if there is none, or if an error of the ranges that all points
  /// share explains the images better: eqs. (A7) to (A10) of the README.
  /// O(points), 0.25 µs a look at a point: 1200 points are looked at in eight places, and in about
  /// 100 if one of these is better. No I/O; on OpenCV's threads, with the same result for any
  /// number.
  ScanMove Estimate(const RangeInput& input, std::span<const ProjectedPoint> points,
                    const cv::Point2d* start_px = nullptr);

 private:
  // How the points are moved: by (x, y) in the left image, px; z nearer, m; and rolled by w, px at
  // half the width.
  using Move = Eigen::Vector4d;
  enum class Freedom { kTurn, kTurnAndRoll, kTurnAndMotion };
  struct Candidate {
    Move move;
    std::vector<float> excess;  // of the nodes
  };

  void Take(const RangeInput& input, std::span<const ProjectedPoint> points, size_t most);
  void Look(const RangeInput& input, const Move& move, std::vector<float>& excess) const;
  void Refine(const RangeInput& input, Freedom freedom, Candidate& candidate);
  double CostOf(const RangeInput& input, const Move& move);
  bool MayBeOff(const RangeInput& input);
  std::vector<Move> StepsOf(double step_px, Freedom freedom) const;
  Move Descend(const RangeInput& input, Move from, double step_px, Freedom freedom);
  double GainInSigmas(const std::vector<float>& before, const std::vector<float>& after) const;
  double CurveGain(const RangeInput& input);

  std::vector<RangeNode> nodes_;    // those that are compared, where they are
  std::vector<float> excess_here_;  // of the nodes
  std::vector<float> excess_;       // the same elsewhere
  double m_per_px_ = 0;             // depth that changes the disparity of a near point by 1 px
  Move start_;                      // where the search starts
  Candidate turn_;
  Candidate roll_;
  Candidate motion_;
  RangeCurve curve_;
};

/// Moves the points.
void ApplyMove(const ScanMove& move, const Rig& rig, std::vector<ProjectedPoint>& points);

/// The move in words, for the status. @pre move.is_off.
std::string ScanMoveText(const ScanMove& move);

}  // namespace sprout::refine
