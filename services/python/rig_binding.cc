#include <pybind11/eigen.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "common/geometry/projection.h"
#include "common/rig/rectifier.h"
#include "common/rig/rig_file.h"
#include "common/scenes/kitti_calibration.h"
#include "services/python/arrays.h"
#include "services/python/bindings.h"

namespace sprout::python {
namespace {

namespace fs = std::filesystem;
using namespace py::literals;  // NOLINT: of _a there is no other
using Distortion = std::array<double, 5>;

std::string NumberText(double number) { return py::repr(py::float_(number)); }

Rig Checked(const Rig& rig) {
  Unwrap(CheckRig(rig));
  return rig;
}

TofCamera MakeTof(int width, int height, double fx, double fy, double cx, double cy,
                  const Distortion& distortion, const py::object& rotation,
                  const std::array<double, 3>& translation_m) {
  return TofCameraOf({width, height, fx, fy, cx, cy, distortion},
                     {TakeRotation(rotation), Eigen::Vector3d(translation_m.data())});
}

Rig MakeRig(int width, int height, double focal_px, double baseline_m, std::optional<double> cx,
            std::optional<double> cy, std::optional<double> cx_right,
            const std::optional<TofCamera>& tof) {
  Rig rig;
  rig.pair = {.width = width,
              .height = height,
              .focal_px = focal_px,
              .cx = cx.value_or((width - 1) / 2.0),
              .cy = cy.value_or((height - 1) / 2.0),
              .cx_right = 0,
              .baseline_m = baseline_m};
  rig.pair.cx_right = cx_right.value_or(rig.pair.cx);
  if (tof) rig.tof = *tof;
  return Checked(rig);
}

// OpenCV's 4×4 matrix: (X, Y, Z, W) = Q · (u, v, d, 1).
Rig FromQ(const py::object& q, int width, int height) {
  const auto m = py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(q);
  if (!m || m.ndim() != 2 || m.shape(0) != 4 || m.shape(1) != 4) {
    PyErr_Clear();
    Refuse("Q", "float64 array of shape (4, 4)", q);
  }
  if (!(m.at(3, 2) > 0)) {
    throw py::value_error("Q[3, 2]: expected 1 / baseline (1/m), above 0, given " +
                          NumberText(m.at(3, 2)) +
                          (m.at(3, 2) < 0 ? "; are left and right swapped?" : ""));
  }
  const double baseline_m = 1 / m.at(3, 2);
  // Q[3, 3] = (cx − cx') / Tx, Q[3, 2] = −1 / Tx.
  const double cx = -m.at(0, 3);
  return MakeRig(width, height, m.at(2, 3), baseline_m, cx, -m.at(1, 3),
                 cx + m.at(3, 3) / m.at(3, 2), {});
}

py::array_t<double> QOf(const Rig& rig) {
  const RectifiedPair& pair = rig.pair;
  const double rows[4][4] = {
      {1, 0, 0, -pair.cx},
      {0, 1, 0, -pair.cy},
      {0, 0, 0, pair.focal_px},
      {0, 0, 1 / pair.baseline_m, (pair.cx_right - pair.cx) / pair.baseline_m}};
  return py::array_t<double>({4, 4}, &rows[0][0]);
}

py::dict DictOf(const TofCamera& tof) {
  const auto& q = tof.left_from_tof_rotation;
  const auto& t = tof.left_from_tof_translation_m;
  return py::dict("width"_a = tof.width, "height"_a = tof.height, "fx"_a = tof.fx, "fy"_a = tof.fy,
                  "cx"_a = tof.cx, "cy"_a = tof.cy, "distortion"_a = tof.distortion,
                  "rotation"_a = py::make_tuple(q.w(), q.x(), q.y(), q.z()),
                  "translation_m"_a = py::make_tuple(t.x(), t.y(), t.z()));
}

py::dict DictOf(const Rig& rig) {
  const RectifiedPair& pair = rig.pair;
  return py::dict("width"_a = pair.width, "height"_a = pair.height, "focal_px"_a = pair.focal_px,
                  "baseline_m"_a = pair.baseline_m, "cx"_a = pair.cx, "cy"_a = pair.cy,
                  "cx_right"_a = pair.cx_right,
                  "tof"_a = rig.tof.width > 0 ? py::object(DictOf(rig.tof)) : py::none());
}

// Calls the class with the keys as arguments, so that missing and unknown keys are named.
py::object FromDict(const char* type, const py::dict& dict) {
  py::dict arguments(**dict);
  if (arguments.contains("tof") && py::isinstance<py::dict>(arguments["tof"])) {
    arguments["tof"] = FromDict("TofCamera", arguments["tof"]);
  }
  try {
    return py::module_::import("sprout._sprout").attr(type)(**arguments);
  } catch (py::error_already_set& error) {
    if (!error.matches(PyExc_TypeError)) throw;
    throw py::value_error(std::string(type) +
                          ".from_dict: expected the keys that to_dict() gives, given " +
                          std::string(py::repr(dict)));
  }
}

// What a pickle calls to make the object again: from_dict() by its name, since it cannot be pickled
// itself.
py::tuple ReduceTo(const char* type, const py::dict& dict) {
  return py::make_tuple(py::module_::import("operator").attr("methodcaller")("from_dict", dict),
                        py::make_tuple(py::module_::import("sprout._sprout").attr(type)));
}

// repr() of an object whose constructor takes the entries of `dict`.
std::string Repr(const std::string& type, const py::dict& dict) {
  std::string text;
  for (const auto& [key, value] : dict) {
    text += (text.empty() ? "" : ", ") + std::string(py::str(key)) + "=";
    text += py::isinstance<py::dict>(value)
                ? Repr("TofCamera", py::reinterpret_borrow<py::dict>(value))
                : std::string(py::repr(value));
  }
  return type + "(" + text + ")";
}

// Adds what DictOf() gives: to_dict() and back, repr() and pickles.
template <typename Value>
void AddDict(py::class_<Value>& bound, const std::string& type) {
  bound
      .def(
          "to_dict", [](const Value& value) { return DictOf(value); },
          "to_dict(self) -> Dict[str, Any]\n\nWhat from_dict() takes; plain numbers and tuples.")
      .def_static(
          "from_dict", [type](const py::dict& dict) { return FromDict(type.c_str(), dict); },
          py::arg("dict"), ("from_dict(dict: Dict[str, Any]) -> " + type).c_str())
      .def("__reduce__",
           [type](const Value& value) { return ReduceTo(type.c_str(), DictOf(value)); });
  AddRepr(bound, [type](const Value& value) { return Repr(type, DictOf(value)); });
}

bool SameRig(const Rig& rig, const py::object& other) {
  return py::isinstance<Rig>(other) && RigId(rig) == RigId(other.cast<const Rig&>());
}

Rig WithTof(Rig rig, const TofCamera& tof) {
  rig.tof = tof;
  return Checked(rig);
}

void BindTofCamera(py::module_& module) {
  py::class_<TofCamera> bound(
      module, "TofCamera", R"(The range camera of a Rig: pinhole, lens, pose. Cannot be changed.)");
  const auto add = PropertiesOf(bound);
  bound.def(
      py::init(&MakeTof), py::arg("width"), py::arg("height"), py::arg("fx"), py::arg("fy"),
      py::arg("cx"), py::arg("cy"), py::arg("distortion") = Distortion{},
      py::arg("rotation") = py::none(), py::arg("translation_m") = std::array<double, 3>{},
      R"(__init__(self, width: int, height: int, fx: float, fy: float, cx: float, cy: float, distortion: Sequence[float] = ..., rotation: Any = ..., translation_m: Sequence[float] = ...) -> None

Sizes, focal lengths and principal point in px; distortion k1, k2, p1, p2, k3 (OpenCV's order).
point_in_left = rotation * point_in_tof + translation_m (m; x right, y down, z forward). rotation is a
3x3 matrix, or a quaternion (w, x, y, z); None: the left rectified camera's.)");
  add("width", "int: px.", &TofCamera::width);
  add("height", "int: px.", &TofCamera::height);
  add("fx", "float: focal length, px.", &TofCamera::fx);
  add("fy", "float: focal length, px.", &TofCamera::fy);
  add("cx", "float: principal point, px.", &TofCamera::cx);
  add("cy", "float: principal point, px.", &TofCamera::cy);
  add("distortion", "List[float]: k1, k2, p1, p2, k3.", &TofCamera::distortion);
  add("rotation", "numpy.ndarray: (3, 3) float64, of the ToF camera in the left rectified frame.",
      [](const TofCamera& tof) {
        return Eigen::Matrix3d(tof.left_from_tof_rotation.toRotationMatrix());
      });
  add("translation_m",
      "numpy.ndarray: (3,) float64, m, where it stands in the left rectified frame.",
      [](const TofCamera& tof) { return Eigen::Vector3d(tof.left_from_tof_translation_m); });
  AddDict(bound, "TofCamera");
}

}  // namespace

Eigen::Quaternion<double, Eigen::DontAlign> TakeRotation(const py::handle& rotation) {
  if (rotation.is_none()) return Eigen::Quaternion<double, Eigen::DontAlign>::Identity();
  const auto numbers = py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(
      py::reinterpret_borrow<py::object>(rotation));
  if (numbers && numbers.ndim() == 1 && numbers.size() == 4) {
    return {numbers.at(0), numbers.at(1), numbers.at(2), numbers.at(3)};
  }
  if (!numbers || numbers.ndim() != 2 || numbers.shape(0) != 3 || numbers.shape(1) != 3) {
    PyErr_Clear();
    Refuse("rotation", "4 numbers (w, x, y, z) or float64 array of shape (3, 3)", rotation);
  }
  Eigen::Matrix3d matrix;
  for (int i = 0; i < 9; ++i) matrix(i / 3, i % 3) = numbers.at(i / 3, i % 3);
  // Loose enough for rotations that are written with few digits.
  constexpr double kTolerance = 1e-4;
  const double off = (matrix * matrix.transpose() - Eigen::Matrix3d::Identity()).norm();
  if (!(off < kTolerance) || matrix.determinant() < 0) {
    throw py::value_error("rotation: expected a rotation, R R^T = 1 and det R = 1, given " +
                          ReprInOneLine(rotation));
  }
  return Eigen::Quaternion<double, Eigen::DontAlign>(matrix).normalized();
}

void BindRig(py::module_& module) {
  BindTofCamera(module);
  py::class_<Rig> bound(module, "Rig",
                        R"(Calibration of a rectified pair, and of its range camera if there is one.

Depth of a disparity d: z = focal_px * baseline_m / (d + cx_right - cx). Cannot be changed; can be
pickled.)");
  const auto add = PropertiesOf(bound);
  bound
      .def(
          py::init(&MakeRig), py::arg("width"), py::arg("height"), py::arg("focal_px"),
          py::arg("baseline_m"), py::arg("cx") = py::none(), py::arg("cy") = py::none(),
          py::arg("cx_right") = py::none(), py::arg("tof") = py::none(),
          R"(__init__(self, width: int, height: int, focal_px: float, baseline_m: float, cx: Optional[float] = ..., cy: Optional[float] = ..., cx_right: Optional[float] = ..., tof: Optional[TofCamera] = ...) -> None

Lengths in px but baseline_m (m). Principal point of the left camera (cx, cy), default the middle of
the image; of the right one (cx_right, cy), default cx. ValueError names what no camera has.)")
      .def_static(
          "from_file",
          [](const fs::path& path) {
            return Rectifier(RequireCalibration(LoadRigFile(path), path)).rig();
          },
          py::arg("path"),
          R"(from_file(path: Union[str, os.PathLike[str]]) -> Rig

The rectified rig of a rig file (sprout-calibrate); its images go through Rectifier first.)")
      .def_static(
          "from_kitti",
          [](const fs::path& path, int width, int height, bool grey) {
            Rig rig;
            rig.pair = scenes::ReadKittiPair(path, {width, height}, grey);
            return Checked(rig);
          },
          py::arg("path"), py::arg("width"), py::arg("height"), py::arg("grey") = false,
          R"(from_kitti(path: Union[str, os.PathLike[str]], width: int, height: int, grey: bool = ...) -> Rig

The pair of a calib.txt of KITTI: P2 and P3, the colour cameras, or P0 and P1.)")
      .def_static("from_q", &FromQ, py::arg("Q"), py::arg("width"), py::arg("height"),
                  R"(from_q(Q: Any, width: int, height: int) -> Rig

From the (4, 4) matrix Q of cv2.stereoRectify(), with translations in m.)")
      .def("with_tof", &WithTof, py::arg("tof"),
           "with_tof(self, tof: TofCamera) -> Rig\n\nThe same pair with this range camera.")
      .def(
          "with_aligned_tof",
          [](const Rig& rig, int width, int height) {
            if (width == 0 && height == 0) {  // means "no range camera" in a rig
              throw py::value_error("tof_width = 0: allowed is 1 to 16384");
            }
            return WithTof(rig, TofOverLeft(rig.pair, {width, height}));
          },
          py::arg("width"), py::arg("height"),
          R"(with_aligned_tof(self, width: int, height: int) -> Rig

The same pair with a range camera that shows what the left one shows, at this resolution.)");
  add("width", "int: px.", [](const Rig& rig) { return rig.pair.width; });
  add("height", "int: px.", [](const Rig& rig) { return rig.pair.height; });
  add("focal_px", "float: focal length, px.", [](const Rig& rig) { return rig.pair.focal_px; });
  add("baseline_m", "float: distance of the cameras, m.",
      [](const Rig& rig) { return rig.pair.baseline_m; });
  add("cx", "float: column of the left principal point, px.",
      [](const Rig& rig) { return rig.pair.cx; });
  add("cy", "float: row of both principal points, px.", [](const Rig& rig) { return rig.pair.cy; });
  add("cx_right", "float: column of the right principal point, px.",
      [](const Rig& rig) { return rig.pair.cx_right; });
  add("tof", "Optional[TofCamera]: the range camera; None: there is none.", [](const Rig& rig) {
    return rig.tof.width > 0 ? std::optional<TofCamera>(rig.tof) : std::nullopt;
  });
  add("rig_id", "str: digest, equal for equal numbers on every machine.",
      [](const Rig& rig) { return RigId(rig); });
  add("K", "numpy.ndarray: (3, 3) float64, intrinsics of the left image and of its depth, px.",
      [](const Rig& rig) { return Intrinsics(rig.pair.focal_px, rig.pair.cx, rig.pair.cy); });
  add("Q", "numpy.ndarray: (4, 4) float64, as cv2.reprojectImageTo3D() takes it.", &QOf);
  bound.def("__eq__", &SameRig, "__eq__(self, other: object) -> bool")
      .def(
          "__hash__", [](const Rig& rig) { return py::hash(py::str(RigId(rig))); },
          "__hash__(self) -> int");
  AddDict(bound, "Rig");
}

}  // namespace sprout::python
