#pragma once

#include <array>
#include <string>
#include <vector>

#include "common/rig/raw_rig.h"
#include "common/rig/rectification.h"
#include "services/tools/calibrate/coverage.h"
#include "services/tools/calibrate/rig_refinement.h"

namespace sprout::calibrate {

/// Quality of one camera's calibration.
struct CameraQuality {
  int views = 0;      ///< in which it sees the board
  double rms_px = 0;  ///< reprojection error of the corners, without outliers
  int outliers = 0;   ///< corners further off than 4 standard deviations, left out of rms_px
  CameraDeviation deviation;
  std::vector<CornerResidual> residuals;
  Ninths corners_in_ninth{};
};

/// Quality of a calibration.
struct CalibrationQuality {
  std::array<CameraQuality, kCameraCount> cameras;
  /// Difference of the rows on which both images of the rectified pair have a corner, px.
  double epipolar_median_px = 0;
  double epipolar_95_px = 0;  ///< 95 % are below
  RectifiedViews views;       ///< what the rectified pair shows
  /// Standard deviation of ToF points projected into the left image due to the calibration, px:
  /// mean over the ToF image, at the worse of nearest_m and farthest_m. 0 without ToF camera.
  double tof_landing_px = 0;
  int ranges = 0;          ///< squares of the board whose range was measured
  double range_rms_m = 0;  ///< corrected range of a square minus that of the board
  double nearest_m = 0;    ///< among the ranges
  double farthest_m = 0;
  double range_sigma_m = 0;  ///< standard deviation of the correction, at the worse of the two
  /// Why it is not good enough, one line each, with what to do; empty: it is good.
  std::vector<std::string> reasons;

  bool is_good() const { return reasons.empty(); }
};

/// @param rig  made from the model. O(corners).
CalibrationQuality QualityOf(const RefinedModel& refined, const RawRig& rig,
                             const std::vector<BoardView>& views);

}  // namespace sprout::calibrate
