#include <pybind11/eigen.h>

#include <string>

#include "services/python/arrays.h"
#include "services/python/bindings.h"

namespace sprout::python {
namespace {

Eigen::Matrix4d MatrixOf(const Pose& pose) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() = pose.rotation.toRotationMatrix();
  matrix.topRightCorner<3, 1>() = pose.translation_m;
  return matrix;
}

}  // namespace

void BindMotion(py::module_& module) {
  py::class_<CameraMotion>(module, "Motion",
                           R"(How the left camera moved, from its images.

A pose T takes a point from the camera's frame now to the frame it had then (m; x right, y down,
z forward): point_then = T[:3, :3] @ point_now + T[:3, 3].)")
      .def_property_readonly(
          "last_from_left", [](const CameraMotion& m) { return MatrixOf(m.last_from_left); },
          "numpy.ndarray: (4, 4) float64, pose in the frame of last_seq; that of no motion after a "
          "reset.")
      .def_property_readonly(
          "start_from_left", [](const CameraMotion& m) { return MatrixOf(m.start_from_left); },
          "numpy.ndarray: (4, 4) float64, pose in the frame of start_seq.")
      .def_property_readonly(
          "covariance",
          [](const CameraMotion& m) {
            return py::array_t<double>({6, 6}, m.covariance.data());
          },
          "numpy.ndarray: (6, 6) float64, of last_from_left: rotation vector (rad), translation "
          "(m); 0 after a reset.")
      .def_property_readonly(
          "last_seq", [](const CameraMotion& m) { return m.last_seq; },
          "int: number of the frame before; of this one after a reset.")
      .def_property_readonly(
          "start_seq", [](const CameraMotion& m) { return m.start_seq; },
          "int: number of the frame of the newest reset.")
      .def_property_readonly(
          "tracked", [](const CameraMotion& m) { return m.tracked; },
          "int: points found in both images.")
      .def_property_readonly(
          "inliers", [](const CameraMotion& m) { return m.inliers; },
          "int: points that move as the camera says.")
      .def_property_readonly(
          "reset", [](const CameraMotion& m) { return std::string(NameOf(m.reset)); },
          "str: why earlier frames were forgotten, as motion_t's RESET constants: \"NONE\" when "
          "they were not.")
      .def_property_readonly(
          "resets", [](const CameraMotion& m) { return m.resets; },
          "int: resets so far, without the first frame.")
      .def(
          "__repr__",
          [](const CameraMotion& m) {
            return "<sprout.Motion " + std::string(NameOf(m.reset)) + " " +
                   std::to_string(m.inliers) + " of " + std::to_string(m.tracked) + " points>";
          },
          "__repr__(self) -> str");
}

}  // namespace sprout::python
