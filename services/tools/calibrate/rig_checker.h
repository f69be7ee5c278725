#ifndef SPROUT_SERVICES_TOOLS_CALIBRATE_RIG_CHECKER_H_
#define SPROUT_SERVICES_TOOLS_CALIBRATE_RIG_CHECKER_H_

#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/config/config.h"
#include "common/core/result.h"
#include "common/core/rig.h"
#include "common/core/tof_image.h"
#include "common/geometry/projection.h"
#include "common/inputs/findings.h"
#include "services/refine/alignment/tof_alignment.h"
#include "services/refine/refiner.h"
#include "services/tools/calibrate/vertical_disparity.h"

namespace sprout::calibrate {

/// What frames without a board show about a calibration. Medians over all frames; NaN: unknown.
struct RigCheck {
  int frames = 0;
  double vertical_px = 0;       ///< how far rows of the right image lie below those of the left one
  cv::Mat1f vertical_cells_px;  ///< the same in 3 rows of 4 parts of the image
  bool has_tof = false;
  int tof_frames = 0;                ///< frames with a sure offset
  cv::Point2d tof_offset_px;         ///< offset to add to projected ToF points in the left image
  double tof_disparity_px = 0;       ///< of the ToF points, minus that of stereo at the same pixel
  double tof_range_m = 0;            ///< the same as depth
  inputs::Findings findings;         ///< what goes in, all frames together
  std::vector<std::string> reasons;  ///< why the rig has to be calibrated again; empty: it is good
};

/// Checks frames of a rectified rig for signs of a knock: rows that do not match, ToF points
/// projected beside the objects they were measured on, ranges that contradict stereo; and for what
/// CheckInputs() asks.
class RigChecker {
 public:
  RigChecker();

  /// @param left, right  rectified pair of the calibrated size, 8UC1 or 8UC3.
  /// @returns an error when sizes do not fit the calibration. O(pixels · disparities): about a
  ///          second at 2 MP.
  Result<void> Add(const cv::Mat& left, const cv::Mat& right, const TofImage& tof, const Rig& rig);

  RigCheck Summary() const;

 private:
  void CompareRanges(const cv::Mat1b& left, const cv::Mat1b& right,
                     const std::vector<ProjectedPoint>& points, const RectifiedPair& pair);

  refine::Refiner refiner_;
  refine::TofAligner aligner_;
  std::optional<TofProjector> projector_;  // of the newest calibration
  std::string projector_rig_id_;
  int frames_ = 0;
  bool has_tof_ = false;
  std::vector<inputs::Findings> findings_;   // of each frame
  std::vector<VerticalDisparity> vertical_;  // of each frame
  std::vector<cv::Point2d> offsets_px_;      // of those that are sure
  std::vector<double> disparities_px_;       // of points
  std::vector<double> ranges_m_;
};

/// The result as text for a terminal: verdict and reasons, then the figures.
std::string CheckText(const RigCheck& check);

}  // namespace sprout::calibrate

#endif  // SPROUT_SERVICES_TOOLS_CALIBRATE_RIG_CHECKER_H_
