#pragma once

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "services/tools/calibrate/range_points.h"

namespace sprout::calibrate {

// The residuals of RefineModel(), for Ceres. A lens is fx, fy, cx, cy, k1, k2, p1, p2, k3;
// a pose in the left camera's frame is a rotation vector and a translation, m.

// Standard deviation of the prior on k3, whose mean is 0. Without it k3 is undetermined, and so is
// the distortion in the image's corners, if no corner of the board was seen there.
inline constexpr double kK3Sigma = 0.1;

// Brown's distortion as in common/geometry/lens.h, of (x, y, 1).
template <typename T>
struct Distorted {
  T radial;
  T tangential[2];

  Distorted(const T* lens, const T& x, const T& y) {
    const T& k1 = lens[4];
    const T& k2 = lens[5];
    const T& p1 = lens[6];
    const T& p2 = lens[7];
    const T& k3 = lens[8];
    const T r2 = x * x + y * y;
    radial = T(1) + r2 * (k1 + r2 * (k2 + r2 * k3));
    tangential[0] = T(2) * p1 * x * y + p2 * (r2 + T(2) * x * x);
    tangential[1] = p1 * (r2 + T(2) * y * y) + T(2) * p2 * x * y;
  }
};

// Rotates into the frame whose pose in the other one is given by its rotation vector.
template <typename T>
void RotateBack(const T* rotation, const T* vector, T* result) {
  const T inverse[3] = {-rotation[0], -rotation[1], -rotation[2]};
  ceres::AngleAxisRotatePoint(inverse, vector, result);
}

// Direction (x, y, 1) of a pixel: fixed-point steps as in DirectionOfPixel(), each of which gains
// more than a digit of some pixels.
template <typename T>
void RayOfPixel(const T* lens, const T& column, const T& row, T* ray) {
  constexpr int kSteps = 8;
  const T u = (column - lens[2]) / lens[0];
  const T v = (row - lens[3]) / lens[1];
  ray[0] = u;
  ray[1] = v;
  ray[2] = T(1);
  for (int step = 0; step < kSteps; ++step) {
    const Distorted<T> distorted(lens, ray[0], ray[1]);
    ray[0] = (u - distorted.tangential[0]) / distorted.radial;
    ray[1] = (v - distorted.tangential[1]) / distorted.radial;
  }
}

// (measured − π(lens, camera⁻¹ · board · X)) / σ, px/px.
struct CornerError {
  Eigen::Vector3d corner;
  cv::Point2d pixel;
  double sigma_px;

  template <typename T>
  bool operator()(const T* lens, const T* left_from_camera, const T* left_from_board,
                  T* residual) const {
    const T on_board[3] = {T(corner.x()), T(corner.y()), T(corner.z())};
    T p[3];
    ceres::AngleAxisRotatePoint(left_from_board, on_board, p);
    for (int i = 0; i < 3; ++i) p[i] += left_from_board[3 + i] - left_from_camera[3 + i];
    T in_camera[3];
    RotateBack(left_from_camera, p, in_camera);
    if (in_camera[2] <= T(0)) return false;
    const T x = in_camera[0] / in_camera[2];
    const T y = in_camera[1] / in_camera[2];
    const Distorted<T> distorted(lens, x, y);
    const T u = x * distorted.radial + distorted.tangential[0];
    const T v = y * distorted.radial + distorted.tangential[1];
    residual[0] = (T(pixel.x) - lens[0] * u - lens[2]) / T(sigma_px);
    residual[1] = (T(pixel.y) - lens[1] * v - lens[3]) / T(sigma_px);
    return true;
  }
};

// (k3 − 0) / σ.
struct K3Prior {
  template <typename T>
  bool operator()(const T* lens, T* residual) const {
    residual[0] = lens[8] / T(kK3Sigma);
    return true;
  }
};

// (scale · measured + offset − range of the board's plane along the pixel's ray) / σ, m/m.
struct RangeError {
  RangePoint point;
  double sigma_m;

  template <typename T>
  bool operator()(const T* lens, const T* left_from_tof, const T* left_from_board, const T* bias,
                  T* residual) const {
    T ray[3];
    RayOfPixel(lens, T(point.pixel.x), T(point.pixel.y), ray);
    const T per_depth = ceres::sqrt(ray[0] * ray[0] + ray[1] * ray[1] + T(1));

    // The plane: normal, and a point on it, in the ToF camera's frame.
    const T axis[3] = {T(0), T(0), T(1)};
    T normal_in_left[3];
    ceres::AngleAxisRotatePoint(left_from_board, axis, normal_in_left);
    T normal[3];
    RotateBack(left_from_tof, normal_in_left, normal);
    const T origin_in_left[3] = {left_from_board[3] - left_from_tof[3],
                                 left_from_board[4] - left_from_tof[4],
                                 left_from_board[5] - left_from_tof[5]};
    T origin[3];
    RotateBack(left_from_tof, origin_in_left, origin);
    const T depth = ceres::DotProduct(normal, origin) / ceres::DotProduct(normal, ray);
    const T measured = T(point.depth_m) * per_depth;
    residual[0] = (bias[0] * measured + bias[1] - depth * per_depth) / T(sigma_m);
    return true;
  }
};

}  // namespace sprout::calibrate
