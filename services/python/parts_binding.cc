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

PriorMap MakePrior(const py::object& disparity, const py::object& sigma) {
  const DisparityImage map = TakeDisparities("disparity", disparity, {});
  PriorMap prior(map.size());
  prior.disparity = map;
  const bool one = PyNumber_Check(sigma.ptr()) != 0 && !py::isinstance<py::array>(sigma);
  const cv::Mat1b counts = one ? cv::Mat1b(map.size(), TakeSigma("sigma_px", py::float_(sigma)))
                               : TakeSigmas("sigma_px", sigma, map.size());
  counts.copyTo(prior.sigma, map.counts() != DisparityImage::kInvalid);
  return prior;
}

Eigen::Matrix4d MatrixOf(const Pose& pose) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() = pose.rotation.toRotationMatrix();
  matrix.topRightCorner<3, 1>() = pose.translation_m;
  return matrix;
}

template <typename T>
using Numbers = py::array_t<T, py::array::c_style | py::array::forcecast>;

using Shape = std::array<py::ssize_t, 3>;

// An array (R, C, N), or (R, C) for (R, C, 1), of NumPy's kind ('f', 'b').
// @param shape  that it must have; nothing: any.
template <typename T>
Numbers<T> TakeTargets(const std::string& name, const py::handle& given, char kind,
                       const std::string& expected, const std::optional<Shape>& shape) {
  if (!py::isinstance<py::array>(given)) Refuse(name, expected, given);
  const py::array any = Unmasked(py::reinterpret_borrow<py::array>(given));
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

// An array (R, C, N) of one value of each target.
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

void BindParts(py::module_& module) {
  PYBIND11_NUMPY_DTYPE(Seed, u, v, u_right, sigma_px, origin, tof_u, tof_v);
  module.attr("SEED") = py::dtype::of<Seed>();
  py::class_<TofImage> tofs(module, "Tof", "A range image, and how strong its signal was.");
  tofs.def(
          py::init([](const py::object& depth_m, const py::object& amplitude) {
            TofImage tof{.depth_m = TakeDepth("depth_m", depth_m, {}), .amplitude = {}};
            if (!amplitude.is_none()) {
              tof.amplitude = TakeFloats("amplitude", amplitude, tof.depth_m.size());
            }
            return tof;
          }),
          py::arg("depth_m"), py::arg("amplitude") = py::none(),
          R"(__init__(self, depth_m: numpy.ndarray, amplitude: Optional[numpy.ndarray] = ...) -> None

depth_m: (H, W) float32 in m along the optical axis, or uint16 in mm; 0 or NaN: no return.
amplitude: (H, W) float32 in the sensor's unit.)")
      .def_property_readonly(
          "depth_m", [](const TofImage& tof) { return ToArray(tof.depth_m); },
          "numpy.ndarray: (H, W) float32, m; 0 or NaN: no return.")
      .def_property_readonly(
          "amplitude", [](const TofImage& tof) { return ToArray(tof.amplitude); },
          "Optional[numpy.ndarray]: (H, W) float32, the sensor's unit.");
  AddRepr(tofs, [](const TofImage& tof) {
    return "<sprout.Tof " + std::to_string(tof.depth_m.cols) + "x" +
           std::to_string(tof.depth_m.rows) + ">";
  });
  py::class_<PriorMap> priors(module, "PriorMap",
                              "A prior disparity map of the left image, and how sure it is.");
  priors
      .def(
          py::init(&MakePrior), py::arg("disparity"), py::arg("sigma_px"),
          R"(__init__(self, disparity: numpy.ndarray, sigma_px: Union[float, numpy.ndarray]) -> None

disparity: (H, W) float32, up to 1023.97 px, NaN: none; kept in 1/32 px. sigma_px: its standard deviation, one for
all or (H, W) float32; kept in 1/16 px, 16 px is as good as not knowing.)")
      .def_property_readonly(
          "disparity", [](const PriorMap& prior) { return ToArray(prior.disparity); },
          "numpy.ndarray: (H, W) float32, px; NaN: none.")
      .def_property_readonly(
          "sigma_px", [](const PriorMap& prior) { return SigmaArray(prior.sigma); },
          "numpy.ndarray: (H, W) float32, standard deviation, px; 15.9375 or more: not known.");
  AddRepr(priors, [](const PriorMap& prior) {
    return "<sprout.PriorMap " + std::to_string(prior.size().width) + "x" +
           std::to_string(prior.size().height) + ">";
  });
}

void BindMotion(py::module_& module) {
  py::class_<CameraMotion> bound(module, "Motion",
                                 R"(How the left camera moved, from its images.

A pose T takes a point from the camera's frame now to the frame it had then (m; x right, y down,
z forward): point_then = T[:3, :3] @ point_now + T[:3, 3].)");
  const auto add = PropertiesOf(bound);
  add("last_from_left",
      "numpy.ndarray: (4, 4) float64, pose in the frame of last_seq; that of no motion after a "
      "reset.",
      [](const CameraMotion& m) { return MatrixOf(m.last_from_left); });
  add("start_from_left", "numpy.ndarray: (4, 4) float64, pose in the frame of start_seq.",
      [](const CameraMotion& m) { return MatrixOf(m.start_from_left); });
  add("covariance",
      "numpy.ndarray: (6, 6) float64, of last_from_left: rotation vector (rad), translation "
      "(m); 0 after a reset.",
      [](const CameraMotion& m) {
        return py::array_t<double>({6, 6}, m.covariance.data());
      });
  add("last_seq", "int: number of the frame before; of this one after a reset.",
      &CameraMotion::last_seq);
  add("start_seq", "int: number of the frame of the newest reset.", &CameraMotion::start_seq);
  add("tracked", "int: points found in both images.", &CameraMotion::tracked);
  add("inliers", "int: points that move as the camera says.", &CameraMotion::inliers);
  add("reset",
      "str: why earlier frames were forgotten, as motion_t's RESET constants: \"NONE\" when "
      "they were not.",
      [](const CameraMotion& m) { return std::string(NameOf(m.reset)); });
  add("resets", "int: resets so far, without the first frame.", &CameraMotion::resets);
  AddRepr(bound, [](const CameraMotion& m) {
    return "<sprout.Motion " + std::string(NameOf(m.reset)) + " " + std::to_string(m.inliers) +
           " of " + std::to_string(m.tracked) + " points>";
  });
}

void BindZones(py::module_& module) {
  py::class_<TofZones> bound(
      module, "Zones",
      R"(What a multi-zone range sensor measured: R x C zones, up to N targets in each.

A zone speaks of an area, not of a pixel, so this is no range image.)");
  const auto add = PropertiesOf(bound);
  bound.def(
      py::init(&MakeZones), py::arg("depth_m"), py::arg("sigma_m"), py::arg("views"),
      py::arg("doubtful") = py::none(), py::arg("mode") = "MEAN", py::arg("rotation") = py::none(),
      py::arg("translation_m") = std::array<double, 3>{},
      R"(__init__(self, depth_m: numpy.ndarray, sigma_m: numpy.ndarray, views: numpy.ndarray, doubtful: Optional[numpy.ndarray] = ..., mode: str = ..., rotation: Any = ..., translation_m: Sequence[float] = ...) -> None

depth_m: (R, C) or (R, C, N) float32, m along the sensor's axis (z, not the range); 0 or NaN: no target.
sigma_m: of the same shape, standard deviation, m. MEAN: of the depths that the light comes from, with
the sensor's noise; NEAREST: of depth_m.
views: (R, C, 4) float32, field of view of each zone in the sensor's frame: x / z where it begins and
ends, y / z where it begins and ends.
doubtful: bool of depth_m's shape: perhaps a target, little light; None: all are sure.
mode: MEAN or NEAREST: which distance of a target depth_m is.
rotation: of the sensor, (3, 3) or quaternion w, x, y, z; translation_m: its place in the left camera's
frame (x right, y down, z forward).)");
  add("depth_m", "numpy.ndarray: (R, C, N) float32, m; 0: no target.",
      [](const TofZones& zones) { return TargetArray<float>(zones, &ZoneTarget::depth_m); });
  add("sigma_m", "numpy.ndarray: (R, C, N) float32, m; 0: no target.",
      [](const TofZones& zones) { return TargetArray<float>(zones, &ZoneTarget::sigma_m); });
  add("doubtful", "numpy.ndarray: (R, C, N) bool.", [](const TofZones& zones) {
    return TargetArray<bool>(
        zones, [](const ZoneTarget& t) { return t.status == TargetStatus::kDoubtful; });
  });
  add("views", "numpy.ndarray: (R, C, 4) float32.", &ViewArray);
  add("mode", "str: MEAN or NEAREST.",
      [](const TofZones& zones) { return zones.mode == ZoneMode::kMean ? "MEAN" : "NEAREST"; });
  add("rotation", "numpy.ndarray: (3, 3) float64.", [](const TofZones& zones) -> Eigen::Matrix3d {
    return zones.left_from_sensor.rotation.toRotationMatrix();
  });
  add("translation_m", "numpy.ndarray: (3,) float64, m.",
      [](const TofZones& zones) -> Eigen::Vector3d {
        return zones.left_from_sensor.translation_m;
      });
  AddRepr(bound, [](const TofZones& zones) {
    return "<sprout.Zones " + std::to_string(zones.columns) + "x" + std::to_string(zones.rows) +
           ">";
  });
}

}  // namespace sprout::python
