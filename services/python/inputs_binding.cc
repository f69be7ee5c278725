#include <fmt/core.h>
#include <pybind11/stl.h>

#include <string>

#include "common/inputs/check_inputs.h"
#include "common/picture/eight_bits.h"
#include "services/python/arrays.h"
#include "services/python/bindings.h"

namespace sprout::python {
namespace {

inputs::Findings CheckInputsOf(const py::object& left, const py::object& right,
                               const py::object& tof, const Rig& rig) {
  CameraImage left_image = TakeCameraImage("left", left, rig.pair.size());
  CameraImage right_image = TakeCameraImage("right", right, rig.pair.size());
  EightBits().Convert({&left_image, &right_image});
  if (!tof.is_none() && rig.tof.width == 0) {
    Refuse("tof", "None, since the rig has no ToF camera (Rig.with_tof)", tof);
  }
  const TofImage ranges = TakeTof("tof", tof, cv::Size(rig.tof.width, rig.tof.height));
  const Unlocked free;
  return inputs::CheckInputs(left_image.pixels, right_image.pixels, ranges, rig);
}

}  // namespace

void BindInputs(py::module_& module) {
  py::class_<inputs::Finding>(module, "Finding", "The answer to one question of check_inputs().")
      .def_property_readonly(
          "question", [](const inputs::Finding& f) { return std::string(NameOf(f.question)); },
          "str: 'scene', 'time', 'sides', 'rows', 'bits', 'hits', 'place', 'scale' or 'moment'.")
      .def_property_readonly(
          "verdict", [](const inputs::Finding& f) { return std::string(NameOf(f.verdict)); },
          "str: 'good', 'bad' or 'cannot tell'.")
      .def_property_readonly(
          "value", [](const inputs::Finding& f) { return f.value; },
          "float: the figure that decided, in `unit`; NaN: not known.")
      .def_property_readonly(
          "sigma", [](const inputs::Finding& f) { return f.sigma; },
          "float: its standard deviation; NaN: not known.")
      .def_property_readonly(
          "unit", [](const inputs::Finding& f) { return std::string(UnitOf(f.question)); },
          "str: of value and sigma: '%', 'px', or '1' for a factor.")
      .def_property_readonly(
          "text", [](const inputs::Finding& f) { return f.text; },
          "str: one line: what was found, and where it is bad, the cure.")
      .def(
          "__repr__",
          [](const inputs::Finding& f) {
            return fmt::format("<sprout.Finding {}: {}: {}>", NameOf(f.question), NameOf(f.verdict),
                               f.text);
          },
          "__repr__(self) -> str");
  module.def(
      "check_inputs", &CheckInputsOf, py::arg("left"), py::arg("right"), py::arg("tof"),
      py::arg("rig"),
      R"(check_inputs(left: numpy.ndarray, right: numpy.ndarray, tof: Union[numpy.ndarray, Tof, None], rig: Rig) -> List[Finding]

Whether the parts of a frame fit each other: one finding a question. Arguments as of
Pipeline.compute().

    for finding in findings:
        if finding.verdict == "bad":
            print(finding.text))");
}

}  // namespace sprout::python
