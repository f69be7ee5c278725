#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "common/core/result.h"
#include "services/tools/calibrate/scene/rig_change.h"
#include "services/tools/calibrate/scene/tof_patches.h"

namespace sprout::calibrate {

/// A point of the scene in both unrectified images.
struct SceneMatch {
  size_t view = 0;
  cv::Point2d left;             ///< px
  cv::Point2d right;            ///< px
  double inverse_depth = 0;     ///< 1 / z in the left camera's frame, 1/m; > 0
  std::optional<TofPatch> tof;  ///< what the ToF camera measured there, away from depth edges
};

/// Where depth edges of the ToF camera lie in the images, of all views together: the turn that the
/// ToF camera needs besides one that was applied already.
struct EdgeShift {
  Eigen::Vector2d turn;     ///< about the rectified left camera's x and y axis, rad
  Eigen::Vector2d sigma;    ///< of either, rad
  Eigen::Vector3d applied;  ///< turn that was applied already, axes of the left camera, rad
  Eigen::Matrix3d rectified_from_left;
};

/// Residuals of one match at a solution.
struct MatchResidual {
  double rows_px = 0;                 ///< how far the right pixel lies below where it should
  std::optional<double> tof_px = {};  ///< disparity of the ToF point less that of stereo
  std::optional<double> tof_m = {};   ///< the same as distance across the surface
};

struct AdjustedScene {
  RigNumbers change{};  ///< 0: stays as it was
  /// Standard deviations, also of what could have changed but did not; expected() where not seen.
  RigNumbers sigma{};
  /// The same if all that stays is right, and the ToF camera stands where the calibration has it: a
  /// change is made when it is sure by these. Where it is not by `sigma`, something else would
  /// explain the frames as well.
  RigNumbers frames_sigma{};
  std::array<bool, kRigNumbers> seen{};  ///< whether the matches determine it
  std::vector<double> inverse_depths;    ///< of the matches, 1/m
  double match_sigma_px = 0;             ///< scatter of a coordinate, robust
};

/// A change of fewer standard deviations is none: a right rig has one of these once in 370.
inline constexpr double kSureChangeSigmas = 3;

/// Which numbers may change.
using Wanted = std::array<bool, kRigNumbers>;

/// Bundle adjustment: the changes of a calibration, and the depth of each match, that minimise the
/// reprojection errors, the distances from the ToF camera's planes, and what depth edges show, each
/// divided by its standard deviation (estimated as well; Cauchy's loss), with a prior that a number
/// changes by what is expected of it. Numbers that are not known better than a third of that stay.
/// One thread; same input, same bytes. About 50 µs a match and solution.
/// @param matches    of a rig; their inverse depths are the start.
/// @param only_sure  numbers whose change is below three standard deviations stay as well, the
/// least
///                   sure first.
/// @returns an error when there is no solution.
Result<AdjustedScene> AdjustScene(const RawRig& rig, const std::vector<SceneMatch>& matches,
                                  const std::optional<EdgeShift>& edges, const Wanted& wanted,
                                  bool only_sure);

/// Residuals of all matches for a change of the calibration. O(matches).
std::vector<MatchResidual> ResidualsOf(const RawRig& rig, const std::vector<SceneMatch>& matches,
                                       const std::vector<double>& inverse_depths,
                                       const RigNumbers& change);

}  // namespace sprout::calibrate
