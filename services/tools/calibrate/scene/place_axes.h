#ifndef SPROUT_SERVICES_TOOLS_CALIBRATE_SCENE_PLACE_AXES_H_
#define SPROUT_SERVICES_TOOLS_CALIBRATE_SCENE_PLACE_AXES_H_

#include <Eigen/Geometry>

namespace sprout::calibrate {

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

#endif  // SPROUT_SERVICES_TOOLS_CALIBRATE_SCENE_PLACE_AXES_H_
