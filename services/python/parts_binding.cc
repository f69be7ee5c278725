#include <pybind11/stl.h>

#include "services/python/arrays.h"
#include "services/python/bindings.h"

namespace sprout::python {
namespace {

PriorMap MakePrior(const py::object& disparity, const py::object& sigma) {
  const DisparityImage map = FromPx(TakeFloats("disparity", disparity, {}));
  PriorMap prior(map.size());
  prior.disparity = map;
  const bool one = PyFloat_Check(sigma.ptr()) || PyLong_Check(sigma.ptr());
  const cv::Mat1b counts = one ? cv::Mat1b(map.size(), SigmaToCounts(sigma.cast<double>()))
                               : TakeSigmas("sigma_px", sigma, map.size());
  counts.copyTo(prior.sigma, map.counts() != DisparityImage::kInvalid);
  return prior;
}

}  // namespace

void BindParts(py::module_& module) {
  PYBIND11_NUMPY_DTYPE(Seed, u, v, u_right, sigma_px, origin, tof_u, tof_v);
  module.attr("SEED") = py::dtype::of<Seed>();
  py::class_<TofImage>(module, "Tof", "A range image, and how strong its signal was.")
      .def(
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
          "Optional[numpy.ndarray]: (H, W) float32, the sensor's unit.")
      .def(
          "__repr__",
          [](const TofImage& tof) {
            return "<sprout.Tof " + std::to_string(tof.depth_m.cols) + "x" +
                   std::to_string(tof.depth_m.rows) + ">";
          },
          "__repr__(self) -> str");
  py::class_<PriorMap>(module, "PriorMap",
                       "A prior disparity map of the left image, and how sure it is.")
      .def(
          py::init(&MakePrior), py::arg("disparity"), py::arg("sigma_px"),
          R"(__init__(self, disparity: numpy.ndarray, sigma_px: Union[float, numpy.ndarray]) -> None

disparity: (H, W) float32, px, NaN: none; kept in 1/32 px. sigma_px: its standard deviation, one for
all or (H, W) float32; kept in 1/16 px, 16 px is as good as not knowing.)")
      .def_property_readonly(
          "disparity", [](const PriorMap& prior) { return ToArray(prior.disparity); },
          "numpy.ndarray: (H, W) float32, px; NaN: none.")
      .def_property_readonly(
          "sigma_px", [](const PriorMap& prior) { return SigmaArray(prior.sigma); },
          "numpy.ndarray: (H, W) float32, standard deviation, px; 15.9375 or more: not known.")
      .def(
          "__repr__",
          [](const PriorMap& prior) {
            return "<sprout.PriorMap " + std::to_string(prior.size().width) + "x" +
                   std::to_string(prior.size().height) + ">";
          },
          "__repr__(self) -> str");
}

}  // namespace sprout::python
