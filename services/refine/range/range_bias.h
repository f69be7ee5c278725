#pragma once

#include <cstdint>
#include <functional>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <vector>

#include "common/core/rig.h"
#include "common/geometry/projection.h"
#include "services/refine/range/range_curve.h"
#include "services/refine/range/range_field.h"
#include "services/refine/range/range_nodes.h"

namespace sprout::refine {

/// How far a frame's range sensor is off, as the images show it.
struct RangeError {
  /// What all points share, as a function of depth; empty: the images show nothing.
  std::vector<RangeKnot> curve;
  bool curve_is_zero = true;  ///< an error is not significant
  /// What the curve moves all points by, px, if it is about the same at all depths; else 0.
  double same_px = 0;
  double moved_share = 0;      ///< of the points, 0 to 1
  double far_moved_share = 0;  ///< the same of those moved by more than kFarMovePx
  /// The same of those moved by so much more than the curve moves all by.
  double far_from_curve_share = 0;
  double contradicted_share = 0;  ///< of the places that have texture to judge by, 0 to 1
  bool rejected = false;          ///< too many of them: no point is believed
  /// The images do not fit each other, so they contradict no sensor: they match nowhere, or on
  /// other rows, or each row in columns of its own.
  bool pair_unfit = false;
  double columns_px = 0;      ///< how far columns of the pair may be off, as its rows are
  bool rows_unfit = false;    ///< fits on other rows, few nodes contradicted: the curve counts
  bool rows_shifted = false;  ///< each row fits in columns of its own, ShiftsRows()
  /// The curve is farther from 0 than a sensor's error can be, at this knot: no point is believed.
  std::optional<RangeKnot> absurd = std::nullopt;

  /// Whether no point is believed.
  bool RejectsAll() const { return rejected || absurd; }
  /// Whether the curve is farther from 0 than data sheets allow, by RangeRules::kDoubtfulOfDepth.
  bool IsBeyondDataSheets() const;
  /// Whether the images show nothing of the sensor.
  bool IsUnknown() const { return pair_unfit && !rows_unfit; }
};

/// What RangeBias estimates.
struct RangeSettings {
  bool field = true;  ///< also what the scene adds; and points that are contradicted are dropped
  bool has_wrong_edges = false;  ///< the sensor's: then every proved offset counts
  double error_m = 0;            ///< systematic error by the data sheet, one standard deviation, m
  /// Matches of stereo that knows nothing of the points: asked where too many are contradicted.
  std::function<std::span<const Seed>()> matches;
};

/// Finds from the pair how far range points are off, and moves them: eqs. (R2) to (R10) of the
/// README. Keeps its memory from frame to frame; one object serves one caller at a time.
class RangeBias {
 public:
  /// @param points  those of input.surface, in their order. They are moved along their rays;
  ///                sigma_px becomes the standard deviation of what is left of the systematic
  ///                error, 0 where a sensor is right. Noise is not in it.
  /// @returns what was found; valid until the next call.
  /// O(points). No I/O; on OpenCV's threads, with the same result for any
  /// number.
  const RangeError& Apply(const RangeInput& input, const RangeSettings& settings,
                          std::span<ProjectedPoint> points);

  /// For each point of the last call: 1 if the images contradict it, else 0.
  const std::vector<uint8_t>& contradicted() const { return contradicted_; }

 private:
  struct PointError {
    double offset_px = 0;
    double variance_px2 = 0;
    bool contradicted = false;
  };

  void FindCurve(const RangeInput& input, double error_m);
  bool FindField(const RangeInput& input, const RangeSettings& settings,
                 std::span<const ProjectedPoint> points);
  void MovePoints(const RangeInput& input, const RangeSettings& settings,
                  std::span<ProjectedPoint> points);
  bool CompareAgain(const RangeInput& input);
  double JudgeNodes();
  bool CurveIsBeyond(const RectifiedPair& pair, double columns_px) const;
  bool JudgePair(const RangeInput& input, const RangeSettings& settings,
                 std::span<const ProjectedPoint> points);
  double MatchedElsewhere(const RangeInput& input, std::span<const Seed> matches) const;
  std::vector<double> NodeMoves() const;
  bool MarkAffected();
  PointError ErrorOf(const TofSurface& surface, const ProjectedPoint& point) const;

  RangeNodes nodes_;
  RangeCurve curve_;
  RangeField field_;
  RangeError error_;
  std::vector<double> start_px_;
  std::vector<uint8_t> unlike_nodes_;  // that the images contradict
  std::vector<uint8_t> wrong_nodes_;   // those of them in patches
  cv::Mat1b affected_;                 // of the nodes' cells
  std::vector<uint8_t> contradicted_;
  std::vector<uint8_t> moved_;
};

}  // namespace sprout::refine
