#include <pybind11/stl.h>

#include "common/app/compute.h"
#include "common/app/version.h"
#include "common/bus/lcm_url.h"
#include "common/config/config_error.h"
#include "common/logfile/log_error.h"
#include "services/python/bindings.h"
#include "services/python/new_object.h"

namespace {

void TranslateErrors(std::exception_ptr error) {
  try {
    if (error) std::rethrow_exception(error);
  } catch (const sprout::ConfigError& e) {
    PyErr_SetString(PyExc_ValueError, e.what());
  } catch (const sprout::LogError& e) {
    PyErr_SetString(PyExc_OSError, e.what());
  } catch (const sprout::BusError& e) {
    PyErr_SetString(PyExc_OSError, e.what());
  }
}

void SetThreads(int count) {
  if (count < 0 || count > sprout::kMaxThreads) {
    throw pybind11::value_error("count: expected 0 to " + std::to_string(sprout::kMaxThreads) +
                                ", given " + std::to_string(count));
  }
  sprout::SetThreads(count);
}

}  // namespace

PYBIND11_MODULE(_sprout, module) {
  namespace python = sprout::python;
  pybind11::options options;
  options.disable_function_signatures();  // each docstring has its own, for people and stubs
  pybind11::register_exception_translator(&TranslateErrors);
  module.doc() = "What package sprout is made of.";
  module.attr("__version__") = sprout::Version();
  python::BindConfig(module);
  python::BindRig(module);
  python::BindRectifier(module);
  python::BindMotion(module);
  python::BindParts(module);
  python::BindZones(module);
  python::BindFrame(module);
  python::BindPipeline(module);
  python::BindInputs(module);
  python::BindLog(module);
  python::BindListen(module);
  python::BindDataset(module);
  python::BindEvaluate(module);
  python::BindStage(module);
  module.def("set_threads", &SetThreads, pybind11::arg("count"),
             R"(set_threads(count: int) -> None

Threads that a computation may use, for the whole process; 0: one a core; at most 1024. Results do not depend on it.)");
  python::RefuseNew(module);
  python::WatchForTheEnd();
}
