#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <string>

#include "common/picture/eight_bits.h"
#include "common/rig/rectifier.h"
#include "common/rig/rig_file.h"
#include "services/python/arrays.h"
#include "services/python/bindings.h"

namespace sprout::python {
namespace {

namespace fs = std::filesystem;

// A rectifier and what it knows of the images' bits from those before.
class PyRectifier {
 public:
  explicit PyRectifier(const fs::path& path)
      : rectifier_(RequireCalibration(LoadRigFile(path), path)) {}

  const Rig& rig() const { return rectifier_.rig(); }

  py::tuple Rectify(const py::object& left, const py::object& right, const py::object& tof) {
    const RawRig& raw = rectifier_.raw();
    CameraImage raw_left = TakeCameraImage("left", left, raw.left.size());
    CameraImage raw_right = TakeCameraImage("right", right, raw.right.size());
    TofImage ranges = TakeTof(tof, raw.tof.size());
    ranges.depth_m = ranges.depth_m.clone();  // it is changed in place
    eight_bits_.Convert({&raw_left, &raw_right});
    if (const std::string note = eight_bits_.TakeNote(); !note.empty()) {
      if (PyErr_WarnEx(PyExc_UserWarning, note.c_str(), 1) != 0) throw py::error_already_set();
    }
    cv::Mat rectified_left;
    cv::Mat rectified_right;
    {
      const Unlocked free;
      rectified_left = rectifier_.RectifyLeft(raw_left.pixels);
      rectified_right = rectifier_.RectifyRight(raw_right.pixels);
      if (!ranges.depth_m.empty()) rectifier_.CorrectRanges(ranges);
    }
    return py::make_tuple(ToArray(rectified_left), ToArray(rectified_right),
                          tof.is_none() ? py::object(py::none()) : py::cast(ranges));
  }

 private:
  const Rectifier rectifier_;
  EightBits eight_bits_;  // used only with the interpreter's lock
};

}  // namespace

void BindRectifier(py::module_& module) {
  py::class_<PyRectifier> bound(
      module, "Rectifier", R"(Turns what the cameras of a rig file see into a rectified pair.)");
  bound
      .def(py::init<const fs::path&>(), py::arg("path"),
           R"(__init__(self, path: Union[str, os.PathLike[str]]) -> None

A rig file, as sprout-calibrate writes it.)")
      .def_property_readonly("rig", &PyRectifier::rig, "Rig: of the rectified images.")
      .def(
          "rectify", &PyRectifier::Rectify, py::arg("left"), py::arg("right"),
          py::arg("tof") = py::none(),
          R"(rectify(self, left: numpy.ndarray, right: numpy.ndarray, tof: Any = ...) -> Tuple[numpy.ndarray, numpy.ndarray, Optional[Tof]]

Images as the cameras gave them (uint8, (H, W) or (H, W, 3); or uint16, of which the bits that the first
pair uses become 8, as in compute()), and the range image with the bias of its ranges taken away.
What compute() takes; bilinear, the same bytes everywhere.)");
  AddRepr(bound, [](const PyRectifier& rectifier) {
    return "Rectifier(" + std::string(py::repr(py::cast(rectifier.rig()))) + ")";
  });
}

}  // namespace sprout::python
