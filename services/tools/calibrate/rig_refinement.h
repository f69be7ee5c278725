#pragma once

#include <array>
#include <vector>

#include "common/core/result.h"
#include "services/tools/calibrate/range_points.h"
#include "services/tools/calibrate/rig_model.h"

namespace sprout::calibrate {

/// A lens's numbers in the order of the refinement: fx, fy, cx, cy, k1, k2, p1, p2, k3.
inline constexpr size_t kLensNumbers = 9;

inline constexpr size_t kPoseNumbers = 6;  ///< rotation vector (rad), position (m)

/// Standard deviations of a camera's parameters, from scatter and number of the corners; systematic
/// errors of the corner finder are not included.
struct CameraDeviation {
  std::array<double, kLensNumbers> lens{};  ///< px; distortion without unit
  std::array<double, kPoseNumbers> pose{};  ///< in the left camera's frame
};

/// Residual of one corner in one camera, px.
struct CornerResidual {
  size_t view = 0;
  cv::Point2d pixel;  ///< measured position
  cv::Point2d error;
};

/// Residual of one square's range.
struct RangeResidual {
  double range_m = 0;  ///< by the model
  double error_m = 0;  ///< corrected range minus that
};

/// The parameters on which projections of ToF points into the left image depend: left lens, ToF
/// lens, ToF pose.
inline constexpr int kLandingNumbers = 2 * kLensNumbers + kPoseNumbers;
using LandingCovariance = Eigen::Matrix<double, kLandingNumbers, kLandingNumbers>;

struct RefinedModel {
  RigModel model;
  std::array<CameraDeviation, kCameraCount> deviations;
  LandingCovariance landing_covariance = LandingCovariance::Zero();  ///< 0 without ToF camera
  Eigen::Matrix2d range_covariance = Eigen::Matrix2d::Zero();        ///< of scale and offset (m)
  std::array<double, kCameraCount> corner_sigma_px{};  ///< scatter of a coordinate, robust
  double range_sigma_m = 0;                            ///< scatter of a square's range, robust
  std::array<std::vector<CornerResidual>, kCameraCount> residuals;
  std::vector<RangeResidual> range_residuals;
};

/// Refines all lenses, the poses of the cameras and those of the board, and the bias of the ranges
/// together: the maximum of the likelihood of all corners and ranges, each camera's with its own
/// standard deviation, which is estimated as well (Cauchy's loss: a wrong corner counts little).
/// The ranges determine the rotation of the ToF camera: from corners alone, a rotation looks much
/// like a shift of the principal point. One thread; same input, same bytes.
///
/// @param ranges  of the ToF camera; without any the bias stays as it is.
/// @returns an error when the views do not determine the calibration.
Result<RefinedModel> RefineModel(const Board& board, const std::vector<BoardView>& views,
                                 const std::vector<RangePoint>& ranges, const RigModel& model);

}  // namespace sprout::calibrate
