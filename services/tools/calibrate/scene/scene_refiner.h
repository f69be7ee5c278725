#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/core/result.h"
#include "common/core/tof_image.h"
#include "common/rig/bilinear_remap.h"
#include "common/rig/raw_rig.h"
#include "common/rig/rectification.h"
#include "services/refine/alignment/tof_alignment.h"
#include "services/tools/calibrate/scene/pair_matches.h"
#include "services/tools/calibrate/scene/range_curve_fit.h"
#include "services/tools/calibrate/scene/rig_change.h"
#include "services/tools/calibrate/scene/scene_adjustment.h"

namespace sprout::calibrate {

/// How well a calibration fits frames. NaN: unknown.
struct SceneFit {
  double rows_median_px = 0;      ///< of how far right pixels lie below the rows of the left ones
  double rows_abs_median_px = 0;  ///< of the distance
  double rows_abs_95_px = 0;      ///< 95 % of the matches are nearer
  double tof_px = 0;              ///< median disparity of the ToF points less that of stereo
  double tof_abs_px = 0;          ///< median of the difference's size
  double tof_m = 0;               ///< median of the same as distance
  double tof_abs_m = 0;
};

/// A match for the report.
struct ShownMatch {
  cv::Point2d left;  ///< px of the rectified left image
  double rows_before_px = 0;
  double rows_after_px = 0;
};

/// A refined calibration, and how it fits.
struct SceneRefinement {
  RawRig rig;
  AdjustedScene adjusted;
  Wanted wanted{};
  int views = 0;
  int matches = 0;
  int tof_matches = 0;
  int edge_views = 0;  ///< whose depth edges showed where the ToF camera looks
  /// What was added to rig.range_correction, of ranges after the change of their offset; empty: no
  /// curve is sure.
  RangeCorrection curve;
  /// The same of rig.amplitude_correction.
  AmplitudeCorrection light;
  SceneFit before;
  SceneFit after;
  std::vector<ShownMatch> shown;
  std::vector<std::string> reasons;  ///< why it is not good, one line each; empty: it is good

  bool is_good() const { return reasons.empty(); }
};

/// What Refine() may change besides the right camera's pitch and roll and, when there are ToF
/// points on surfaces, its yaw, the ToF camera's rotation and the offset of its ranges. All of
/// these look much like errors of the lenses' distortion, so only for lenses that are known well
/// (NOTES.md).
struct SceneWishes {
  bool focal = false;  ///< focal lengths
  bool row = false;    ///< the right principal row
  bool place = false;  ///< the direction of the baseline
  bool yaw = false;    ///< the yaw also where no ToF point shows it
};

/// How much time a refinement may take. With less effort standard deviations are larger.
struct SceneEffort {
  MatchEffort match;
  size_t max_matches = 8000;  ///< of all frames together, of each evenly
};

/// Effort that tells whether a calibration holds, not its last digits: of selfcalibrate and of
/// check.
SceneEffort QuickEffort(const RectifiedPair& pair);

/// Refines a rig's calibration from frames of any scene, without a board: from matches of the pair,
/// ToF points on smooth surfaces, and depth edges (services/tools/calibrate/README.md).
class SceneRefiner {
 public:
  /// Most frames that are used: more take time and memory, and show the same errors.
  static constexpr int kMaxViews = 24;

  /// @param rig      to be refined.
  /// @param images   how the frames were rectified: RectificationOf(rig), or for RawRigOf() no
  ///                 rotation.
  SceneRefiner(const RawRig& rig, const Rectification& images, const SceneEffort& effort = {});

  /// Searches a frame for matches. Keeps its images, in grey.
  /// @param left, right  rectified, of the rig's size, 8UC1 or 8UC3.
  /// @param tof          with the rig's range bias removed; 0×0: none.
  /// @returns an error when sizes do not fit the calibration. About a second at 2 MP.
  Result<void> Add(const cv::Mat& left, const cv::Mat& right, const TofImage& tof);

  /// @returns an error that says why the frames show too little: few matches, on one side, on one
  ///          plane, at odds with each other. Seconds.
  Result<SceneRefinement> Refine(const SceneWishes& wishes);

  int views() const { return static_cast<int>(views_.size()); }

  /// The frame with the most matches, rectified as it came, grey.
  struct View {
    cv::Mat1b left;
    cv::Mat1b right;
    TofImage tof;
    int matches = 0;
    int features = 0;  ///< of the image with fewer
  };
  const View& best_view() const;

  /// The rig of the frames as they came, rectified.
  Rig RigBefore() const { return RectifiedRig(rig_, images_); }

  /// Turns images that were rectified in one way into those of another calibration, see
  /// RectifyAgain().
  BilinearRemap LeftAgain(const RawRig& by, const Rectification& to) const;
  BilinearRemap RightAgain(const RawRig& by, const Rectification& to) const;

 private:
  void ThinOut();
  void AttachPatches(const RawRig& rig);
  std::optional<EdgeShift> FindEdges(const RigNumbers& change);
  // Fills in what changes: `wanted`, `adjusted`, `curve`, `light`, `before` and `tof_matches`.
  Result<void> Adjust(const SceneWishes& wishes, SceneRefinement& result);
  double MiddleAmplitude() const;
  // Finds the errors that ranges still have with the change applied: `curve` and `light`.
  void FindCorrections(SceneRefinement& result) const;
  SceneFit FitOf(const std::vector<MatchResidual>& residuals) const;

  RawRig rig_;
  Rectification images_;
  SceneEffort effort_;
  std::vector<View> views_;
  std::vector<SceneMatch> matches_;
  std::vector<cv::Point2d> left_px_;  // of the matches, rectified
  refine::TofAligner aligner_;
  int edge_views_ = 0;
};

}  // namespace sprout::calibrate
