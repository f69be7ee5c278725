#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>

#include "common/core/tof_zones.h"
#include "services/python/arrays.h"
#include "services/python/bindings.h"

namespace sprout::python {
namespace {

template <typename T>
using Numbers = py::array_t<T, py::array::c_style | py::array::forcecast>;

using Shape = std::array<py::ssize_t, 3>;

// An array (R, C, N), or (R, C) for (R, C, 1), of NumPy's kind ('f', 'b').
// @param shape  that it must have; nothing: any.
template <typename T>
Numbers<T> TakeTargets(const std::string& name, const py::handle& given, char kind,
                       const std::string& expected, const std::optional<Shape>& shape) {
  if (!py::isinstance<py::array>(given)) Refuse(name, expected, given);
  const auto any = py::reinterpret_borrow<py::array>(given);
  if (any.dtype().kind() != kind || any.ndim() < 2 || any.ndim() > 3) Refuse(name, expected, given);
  Numbers<T> array(any);
  const Shape own = {array.shape(0), array.shape(1), array.ndim() == 3 ? array.shape(2) : 1};
  if (own != shape.value_or(own)) Refuse(name, expected, given);
  return array.reshape(own);
}

ZoneMode TakeMode(const std::string& mode) {
  if (mode == "MEAN") return ZoneMode::kMean;
  if (mode == "NEAREST") return ZoneMode::kNearest;
  throw py::value_error("mode: expected MEAN or NEAREST, given '" + mode + "'");
}

// The status of a target; kNone where there is no depth.
TargetStatus StatusOf(float depth_m, bool doubtful) {
  if (std::isnan(depth_m) || depth_m == 0) return TargetStatus::kNone;
  return doubtful ? TargetStatus::kDoubtful : TargetStatus::kValid;
}

TofZones MakeZones(const py::object& depth_m, const py::object& sigma_m, const py::object& views,
                   const py::object& doubtful, const std::string& mode, const py::object& rotation,
                   const std::array<double, 3>& translation_m) {
  const auto depths =
      TakeTargets<float>("depth_m", depth_m, 'f', "float32 array of shape (R, C) or (R, C, N)", {});
  const Shape shape = {depths.shape(0), depths.shape(1), depths.shape(2)};
  const auto sigmas =
      TakeTargets<float>("sigma_m", sigma_m, 'f', "float32 array of depth_m's shape", shape);
  const auto tangents = TakeTargets<float>("views", views, 'f',
                                           "float32 array of shape (R, C, 4), as depth_m has R, C",
                                           Shape{shape[0], shape[1], 4});
  const auto doubts =
      doubtful.is_none()
          ? Numbers<bool>()
          : TakeTargets<bool>("doubtful", doubtful, 'b', "bool array of depth_m's shape", shape);
  TofZones zones{
      .columns = static_cast<int>(shape[1]),
      .rows = static_cast<int>(shape[0]),
      .targets_per_zone = static_cast<int>(shape[2]),
      .mode = TakeMode(mode),
      .left_from_sensor = {TakeRotation(rotation), Eigen::Vector3d(translation_m.data())},
      .views = {},
      .targets = {}};
  for (const float* view = tangents.data(); view != tangents.data() + tangents.size(); view += 4) {
    zones.views.push_back({view[0], view[1], view[2], view[3]});
  }
  for (py::ssize_t i = 0; i < depths.size(); ++i) {
    const float depth = depths.data()[i];
    const TargetStatus status = StatusOf(depth, !doubtful.is_none() && doubts.data()[i]);
    zones.targets.push_back(
        status == TargetStatus::kNone ? ZoneTarget() : ZoneTarget{depth, sigmas.data()[i], status});
  }
  Unwrap(CheckZones(zones));
  return zones;
}

// (R, C, N) of what the targets have.
template <typename Value, typename Get>
py::array TargetArray(const TofZones& zones, const Get& get) {
  py::array_t<Value> array({zones.rows, zones.columns, zones.targets_per_zone});
  std::ranges::transform(zones.targets, array.mutable_data(), get);
  return array;
}

py::array ViewArray(const TofZones& zones) {
  py::array_t<float> array({zones.rows, zones.columns, 4});
  float* side = array.mutable_data();
  for (const ZoneView& view : zones.views) {
    for (const float value : {view.left, view.right, view.top, view.bottom}) *side++ = value;
  }
  return array;
}

}  // namespace

void BindZones(py::module_& module) {
  py::class_<TofZones>(
      module, "Zones",
      R"(What a multi-zone range sensor measured: R x C zones, up to N targets in each.

A zone speaks of an area, not of a pixel, so this is no range image.)")
      .def(
          py::init(&MakeZones), py::arg("depth_m"), py::arg("sigma_m"), py::arg("views"),
          py::arg("doubtful") = py::none(), py::arg("mode") = "MEAN",
          py::arg("rotation") = py::none(), py::arg("translation_m") = std::array<double, 3>{},
          R"(__init__(self, depth_m: numpy.ndarray, sigma_m: numpy.ndarray, views: numpy.ndarray, doubtful: Optional[numpy.ndarray] = ..., mode: str = ..., rotation: Any = ..., translation_m: Sequence[float] = ...) -> None

depth_m: (R, C) or (R, C, N) float32, m along the sensor's axis (z, not the range); 0 or NaN: no target.
sigma_m: of the same shape, standard deviation, m. MEAN: of the depths that the light comes from, with
the sensor's noise; NEAREST: of depth_m.
views: (R, C, 4) float32, field of view of each zone in the sensor's frame: x / z where it begins and
ends, y / z where it begins and ends.
doubtful: bool of depth_m's shape: perhaps a target, little light; None: all are sure.
mode: MEAN or NEAREST: which distance of a target depth_m is.
rotation: of the sensor, (3, 3) or quaternion w, x, y, z; translation_m: its place in the left camera's
frame (x right, y down, z forward).)")
      .def_property_readonly(
          "depth_m",
          [](const TofZones& zones) {
            return TargetArray<float>(zones, [](const ZoneTarget& t) { return t.depth_m; });
          },
          "numpy.ndarray: (R, C, N) float32, m; 0: no target.")
      .def_property_readonly(
          "sigma_m",
          [](const TofZones& zones) {
            return TargetArray<float>(zones, [](const ZoneTarget& t) { return t.sigma_m; });
          },
          "numpy.ndarray: (R, C, N) float32, m; 0: no target.")
      .def_property_readonly(
          "doubtful",
          [](const TofZones& zones) {
            return TargetArray<bool>(
                zones, [](const ZoneTarget& t) { return t.status == TargetStatus::kDoubtful; });
          },
          "numpy.ndarray: (R, C, N) bool.")
      .def_property_readonly("views", &ViewArray, "numpy.ndarray: (R, C, 4) float32.")
      .def_property_readonly(
          "mode",
          [](const TofZones& zones) { return zones.mode == ZoneMode::kMean ? "MEAN" : "NEAREST"; },
          "str: MEAN or NEAREST.")
      .def_property_readonly(
          "rotation",
          [](const TofZones& zones) -> Eigen::Matrix3d {
            return zones.left_from_sensor.rotation.toRotationMatrix();
          },
          "numpy.ndarray: (3, 3) float64.")
      .def_property_readonly(
          "translation_m",
          [](const TofZones& zones) -> Eigen::Vector3d {
            return zones.left_from_sensor.translation_m;
          },
          "numpy.ndarray: (3,) float64, m.")
      .def(
          "__repr__",
          [](const TofZones& zones) {
            return "<sprout.Zones " + std::to_string(zones.columns) + "x" +
                   std::to_string(zones.rows) + ">";
          },
          "__repr__(self) -> str");
}

}  // namespace sprout::python
