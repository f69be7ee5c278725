#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <Eigen/Geometry>
#include <atomic>
#include <chrono>
#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "common/config/config.h"
#include "common/core/frame.h"
#include "common/core/result.h"
#include "common/scenes/dataset.h"
#include "services/python/gil.h"

namespace sprout::python {

namespace py = pybind11;

/// What Python knows as a Frame: of a pipeline, a log, the bus or a data set; what it does not have
/// is empty.
struct PyFrame {
  Frame frame;
  cv::Mat1f depth_m = {};                   ///< empty until it is computed
  cv::Mat1f disparity_px = {};              ///< empty until it is computed
  std::vector<std::string> warnings = {};   ///< see DepthFrame
  std::string range_error = {};             ///< see DepthFrame
  std::optional<DisparityImage> kept = {};  ///< the disparities with depth and points, if not all
  bool depth_of_fused = false;              ///< depths and points are those of the fused map
  scenes::GroundTruth truth = {};           ///< of a data set
};

// Each adds its classes to the module. Types come before those that name them.
void BindConfig(py::module_& module);
void BindRig(py::module_& module);
void BindRectifier(py::module_& module);
void BindMotion(py::module_& module);
void BindParts(py::module_& module);
void BindZones(py::module_& module);
void BindFrame(py::module_& module);
void BindPipeline(py::module_& module);
void BindInputs(py::module_& module);
void BindLog(py::module_& module);
void BindListen(py::module_& module);
void BindDataset(py::module_& module);
void BindEvaluate(py::module_& module);
void BindStage(py::module_& module);

/// Config, or what makes one: a str, a path, or several.
SproutConfig TakeConfig(const py::handle& config);

/// Part of a name as Python has it: "left_seeds" is SPROUT_LEFT_SEEDS.
/// @throws pybind11::value_error naming the allowed ones.
Part TakePart(const std::string& name);
std::string NameOf(Part part);

/// A set of them from a sequence of names; every part from None.
PartSet TakeParts(const py::handle& names);

/// Sets a Python error of a text in which names of files may have bytes that are not UTF-8.
void SetError(PyObject* type, const std::string& text);

/// A str of names of files, whose bytes need not be UTF-8, and back: what is not is a surrogate, as
/// in all of Python.
py::str TextOfBytes(const std::string& bytes);
std::string BytesOfText(const py::str& text);

/// The value, or a ValueError.
template <typename T>
T Unwrap(Result<T> result) {
  if (!result) throw py::value_error(result.error().text);
  if constexpr (!std::is_void_v<T>) return std::move(*result);
}

/// What adds properties that cannot be set to a class: a member of it, or what a function gives.
template <typename Class>
auto PropertiesOf(Class& python) {
  return [&python]<typename Get>(const char* name, const char* doc, const Get& get) {
    if constexpr (std::is_member_object_pointer_v<Get>) {
      python.def_readonly(name, get, doc);
    } else {
      python.def_property_readonly(name, get, doc);
    }
  };
}

/// Adds what repr() of an object gives.
template <typename Class, typename Get>
void AddRepr(Class& python, const Get& get) {
  python.def("__repr__", get, "__repr__(self) -> str");
}

/// A rotation from None (there is none), 4 numbers (w, x, y, z) or (3, 3).
Eigen::Quaternion<double, Eigen::DontAlign> TakeRotation(const py::handle& rotation);

/// (3, 3) of a camera with square pixels.
inline py::array_t<double> Intrinsics(double focal_px, double cx, double cy) {
  const double rows[3][3] = {{focal_px, 0, cx}, {0, focal_px, cy}, {0, 0, 1}};
  return py::array_t<double>({3, 3}, &rows[0][0]);
}

/// Held while an object works that only one thread may use at a time.
class Turn {
 public:
  /// @throws std::runtime_error (RuntimeError) when another thread has it.
  Turn(std::atomic_flag& taken, const char* what) : taken_(taken) {
    if (!taken_.test_and_set(std::memory_order_acquire)) return;
    throw std::runtime_error(std::string(what) +
                             ": in use by another thread; allowed: one for each thread");
  }
  ~Turn() { taken_.clear(std::memory_order_release); }
  Turn(const Turn&) = delete;
  Turn& operator=(const Turn&) = delete;

 private:
  std::atomic_flag& taken_;
};

/// Called during long work without the interpreter's lock, so that Ctrl-C is handled now and then.
class SignalCheck {
 public:
  /// @throws error_already_set when a handler raised, as KeyboardInterrupt.
  void operator()() {
    const auto now = std::chrono::steady_clock::now();
    if (now < next_) return;
    next_ = now + kPeriod;
    const Locked gil;
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
  }

  static constexpr std::chrono::milliseconds kPeriod{50};

 private:
  std::chrono::steady_clock::time_point next_{};
};

}  // namespace sprout::python
