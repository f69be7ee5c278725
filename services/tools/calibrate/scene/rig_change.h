#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <opencv2/core.hpp>

#include "common/core/result.h"
#include "common/rig/bilinear_remap.h"
#include "common/rig/raw_rig.h"
#include "common/rig/rectifier.h"
#include "services/tools/calibrate/board_view.h"

namespace sprout::calibrate {

/// A triplet as the cameras gave it, rectified, and without the bias of its ranges. O(pixels).
/// @returns an error when sizes do not fit the calibration.
Result<RigImages> RectifyImages(const Rectifier& rectifier, RigImages images);

/// The numbers of a rig that a scene without a board can show, as changes of a calibration.
enum RigNumber : size_t {
  kPitch,  ///< of the right camera about the left one's x, y and z axis, rad
  kYaw,
  kRoll,
  kPlaceY,  ///< direction of the right camera's place, down and forward, rad
  kPlaceZ,
  kFocal,       ///< of both focal lengths, relative
  kFocalRight,  ///< of the right one alone, relative
  kRowRight,    ///< of the right principal point, px
  kTofPitch,    ///< of the ToF camera about its own place, axes of the left camera, rad
  kTofYaw,
  kTofRoll,
  kRangeOffset,  ///< m
};
inline constexpr size_t kRigNumbers = kRangeOffset + 1;

/// One value each, in the order of RigNumber.
using RigNumbers = std::array<double, kRigNumbers>;

/// How a number is shown.
struct RigNumberRow {
  const char* name;
  const char* unit;
  double per_unit;  ///< shown = per_unit · number
  int digits;       ///< behind the point
  /// What a knock and warmth do, as standard deviation: a number that is not seen any better than
  /// this stays.
  double expected;
};
const RigNumberRow& RowOf(RigNumber number);

/// The calibration with the changes: right.rotation = exp(pitch, yaw, roll) · rotation, and so on.
RawRig Changed(const RawRig& rig, const RigNumbers& change);

/// How far a change moves points somewhere in the rectified images at most, px.
struct MovedPx {
  double right = 0;  ///< points in the right image, against those of the left one
  double tof = 0;    ///< points of the ToF camera in the left image, but for their ranges
};
MovedPx MaxMoved(const RigNumbers& change, const RectifiedPair& pair);

/// A rectified rig as an unrectified one whose lenses do not distort: for frames whose original
/// images are lost.
RawRig RawRigOf(const Rig& rig);

/// A camera of a pair, and how its images are rectified.
struct RectifiedCamera {
  Lens lens;
  cv::Matx33d turn;  ///< from the camera's frame to the rectified one
  RectifiedPair pair;
  double cx = 0;  ///< of this camera's rectified images, px
};

/// Turns images that were rectified in one way into those that another calibration of the same
/// camera makes. O(pixels), about a second at 2 MP: one for all images.
BilinearRemap RectifyAgain(const RectifiedCamera& from, const RectifiedCamera& to);

/// The two directions in which a baseline may turn; its length, which no image shows, stays.
class PlaceAxes {
 public:
  /// @param place_m  of the right camera; not along z.
  explicit PlaceAxes(const Eigen::Vector3d& place_m)
      : place_m_(place_m),
        down_(Eigen::Vector3d::UnitZ().cross(place_m).normalized()),
        forward_(place_m.normalized().cross(down_)) {}

  /// The place, turned by small angles (rad).
  template <typename T>
  Eigen::Matrix<T, 3, 1> Moved(const T& down, const T& forward) const {
    const Eigen::Matrix<T, 3, 1> moved = place_m_.cast<T>() +
                                         (T(place_m_.norm()) * down) * down_.cast<T>() +
                                         (T(place_m_.norm()) * forward) * forward_.cast<T>();
    return moved * (T(place_m_.norm()) / moved.norm());
  }

 private:
  Eigen::Vector3d place_m_;
  Eigen::Vector3d down_;
  Eigen::Vector3d forward_;
};

}  // namespace sprout::calibrate
