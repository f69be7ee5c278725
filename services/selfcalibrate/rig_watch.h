#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/config/config.h"
#include "common/core/frame.h"
#include "common/core/result.h"
#include "common/core/rig.h"
#include "common/core/rig_change.h"
#include "common/core/stage_status.h"
#include "common/inputs/findings.h"
#include "common/rig/range_correction.h"
#include "services/tools/calibrate/scene/scene_refiner.h"

namespace sprout::selfcalibrate {

/// A result as one line: figures with their standard deviations, px in the middle of the image, or
/// why nothing is seen.
std::string ChangeText(const RigChange& change, const RectifiedPair& pair);

/// What to do about a wrong calibration, one line.
/// @param applied  whether capture is asked to change it.
std::string AdviceText(bool applied);

/// What has to be added to the ranges (a curve that is not empty), at its nearest and farthest knot
/// and where it is most, with standard deviations, and what to do, one line.
std::string CurveText(const RangeCorrection& curve);

/// The ToF camera's turn as a shift of its points in the middle of the left image.
TofOffsetStatus OffsetOf(const RigChange& change, const RectifiedPair& pair);

/// Measures by how much a rig differs from its calibration, from frames of any scene. Every
/// config.frames frames are one measurement, as `sprout-calibrate refine` makes it, with less
/// effort; then they are forgotten. Knows no time: the caller chooses the frames.
class RigWatch {
 public:
  /// @throws ConfigError for a value out of range.
  explicit RigWatch(const SelfCalibrateConfig& config);

  /// Takes a frame with LEFT, RIGHT, TOF and RIG. One of another calibration starts again.
  /// @returns what this frame and those before it show, when they are enough; where no calibration
  ///          can be told, the reason also has what CheckInputs() finds bad of the pairs (rows far
  ///          apart, sides swapped ...); an error when its sizes do not fit its calibration. At 2
  ///          MP 0.2 s, and 0.6 s more with a result, or 4 s when the calibration is wrong.
  Result<std::optional<RigChange>> Add(const Frame& frame);

  /// Begins again with the next frame.
  void Forget() { refiner_.reset(); }

  /// What the last result would add to the ranges as they are, as a curve of the range: the change
  /// of their offset, and what is left of the error behind it; one knot: the same at every range;
  /// empty: nothing is sure. rig_change_t has no place for a curve: sprout-calibrate refine writes
  /// it into the rig file.
  const RangeCorrection& curve() const { return curve_; }

 private:
  RigChange Measure(const FrameId& newest);
  RigChange Unseen(RigChange change, const std::string& reason) const;
  void FillRows(const calibrate::SceneRefinement& refined, RigChange& change) const;
  void FillNumbers(const calibrate::SceneRefinement& refined, RigChange& change) const;
  bool IsWrong(const calibrate::SceneRefinement& refined) const;

  SelfCalibrateConfig config_;
  RangeCorrection curve_;
  RectifiedPair pair_;
  std::string rig_id_;                              // of the frames in refiner_
  std::optional<calibrate::SceneRefiner> refiner_;  // nothing before the first frame
  std::vector<inputs::Findings> findings_;          // of the same frames' pairs
};

}  // namespace sprout::selfcalibrate
