#pragma once

#include <Eigen/Geometry>
#include <array>

#include "services/tools/calibrate/rig_residuals.h"
#include "services/tools/calibrate/scene/scene_adjustment.h"

namespace sprout::calibrate {

// The residuals of AdjustScene(), for Ceres. Blocks: `turn` is kPitch, kYaw, kRoll; `place`
// kPlaceY, kPlaceZ; `lens` kFocal, kFocalRight, kRowRight; `tof_turn` kTofPitch, kTofYaw, kTofRoll;
// `offset` kRangeOffset; and the inverse depth of the point.

// A lens with another focal length and principal row: fx, fy, cx, cy, k1, k2, p1, p2, k3.
template <typename T>
std::array<T, 9> LensNumbersOf(const Lens& lens, const T& scale, const T& rows_px) {
  const auto& k = lens.distortion;
  return {scale * lens.fx, scale * lens.fy, T(lens.cx), rows_px + lens.cy, T(k[0]), T(k[1]),
          T(k[2]),         T(k[3]),         T(k[4])};
}

// exp(turn) · first, inverted, of a vector.
template <typename T>
Eigen::Matrix<T, 3, 1> IntoTurned(const T* turn, const Eigen::Matrix3d& first,
                                  const Eigen::Matrix<T, 3, 1>& vector) {
  T turned[3];
  RotateBack(turn, vector.data(), turned);
  return first.transpose().cast<T>() * Eigen::Matrix<T, 3, 1>(turned[0], turned[1], turned[2]);
}

template <typename T>
Eigen::Matrix<T, 3, 1> LeftRay(const RawRig& rig, const T* lens, const cv::Point2d& pixel) {
  const std::array<T, 9> left = LensNumbersOf<T>(rig.left, T(1) + lens[0], T(0));
  Eigen::Matrix<T, 3, 1> ray;
  RayOfPixel(left.data(), T(pixel.x), T(pixel.y), ray.data());
  return ray;
}

// (measured − π(right lens, right camera⁻¹ · (ray / inverse depth))) / σ, px/px.
struct MatchError {
  const RawRig& rig;
  const SceneMatch& match;
  double column_sigma_px;
  double row_sigma_px;

  template <typename T>
  bool operator()(const T* turn, const T* place, const T* lens, const T* inverse_depth,
                  T* residual) const {
    const Eigen::Matrix<T, 3, 1> right_place =
        PlaceAxes(rig.left_from_right.translation_m).Moved(place[0], place[1]);
    const Eigen::Matrix<T, 3, 1> ray = LeftRay(rig, lens, match.left);
    const Eigen::Matrix<T, 3, 1> p =
        IntoTurned<T>(turn, rig.left_from_right.rotation.toRotationMatrix(),
                      ray - inverse_depth[0] * right_place);
    if (p[2] <= T(0)) return false;
    const std::array<T, 9> right =
        LensNumbersOf<T>(rig.right, (T(1) + lens[0]) * (T(1) + lens[1]), lens[2]);
    const T x = p[0] / p[2];
    const T y = p[1] / p[2];
    const Distorted<T> distorted(right.data(), x, y);
    const T u = x * distorted.radial + distorted.tangential[0];
    const T v = y * distorted.radial + distorted.tangential[1];
    residual[0] = (T(match.right.x) - right[0] * u - right[2]) / T(column_sigma_px);
    residual[1] = (T(match.right.y) - right[1] * v - right[3]) / T(row_sigma_px);
    return true;
  }
};

// Distance of the point from the plane that the ToF camera measured, / σ, m/m.
struct PatchError {
  const RawRig& rig;
  const SceneMatch& match;  // with a patch
  double sigma_m;

  template <typename T>
  bool operator()(const T* lens, const T* tof_turn, const T* offset, const T* inverse_depth,
                  T* residual) const {
    const Eigen::Matrix<T, 3, 1> ray = LeftRay(rig, lens, match.left);
    if (inverse_depth[0] <= T(0)) return false;
    const Eigen::Matrix<T, 3, 1> point =
        IntoTurned<T>(tof_turn, rig.left_from_tof.rotation.toRotationMatrix(),
                      ray / inverse_depth[0] - rig.left_from_tof.translation_m.cast<T>());
    const TofPatch& patch = *match.tof;
    residual[0] =
        (patch.normal.cast<T>().dot(point) - patch.distance_m - patch.per_range * offset[0]) /
        T(sigma_m);
    return true;
  }
};

// Turn of the ToF camera that the depth edges show, / σ.
struct EdgeError {
  const EdgeShift& shift;

  template <typename T>
  bool operator()(const T* tof_turn, T* residual) const {
    Eigen::Matrix<T, 3, 1> turn;
    for (int i = 0; i < 3; ++i) turn[i] = tof_turn[i] - shift.applied[i];
    const Eigen::Matrix<T, 3, 1> rectified = shift.rectified_from_left.cast<T>() * turn;
    for (int i = 0; i < 2; ++i) residual[i] = (rectified[i] - shift.turn[i]) / shift.sigma[i];
    return true;
  }
};

}  // namespace sprout::calibrate
