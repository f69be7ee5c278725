#include <pybind11/stl.h>

#include <iterator>

#include "common/app/compute.h"
#include "common/app/log.h"
#include "common/app/version.h"
#include "common/bus/lcm_url.h"
#include "common/config/config_error.h"
#include "common/core/printable.h"
#include "common/logfile/log_error.h"
#include "services/python/bindings.h"

void sprout::python::SetError(PyObject* type, const std::string& text) {
  PyErr_SetString(type, PrintableLines(text).c_str());
}

pybind11::str sprout::python::TextOfBytes(const std::string& bytes) {
  auto text = pybind11::reinterpret_steal<pybind11::str>(
      PyUnicode_DecodeFSDefaultAndSize(bytes.data(), std::ssize(bytes)));
  if (!text) throw pybind11::error_already_set();
  return text;
}

std::string sprout::python::BytesOfText(const pybind11::str& text) {
  const auto bytes =
      pybind11::reinterpret_steal<pybind11::bytes>(PyUnicode_EncodeFSDefault(text.ptr()));
  if (!bytes) throw pybind11::error_already_set();
  return bytes;
}

namespace {

using sprout::python::SetError;

void TranslateErrors(std::exception_ptr error) {
  try {
    if (error) std::rethrow_exception(error);
  } catch (const sprout::ConfigError& e) {
    SetError(PyExc_ValueError, e.what());
  } catch (const pybind11::value_error& e) {
    SetError(PyExc_ValueError, e.what());
  } catch (const sprout::LogError& e) {
    SetError(PyExc_OSError, e.what());
  } catch (const sprout::BusError& e) {
    SetError(PyExc_OSError, e.what());
  }
}

void SetThreads(int count) {
  if (count < 0 || count > sprout::kMaxThreads) {
    throw pybind11::value_error("count: expected 0 to " + std::to_string(sprout::kMaxThreads) +
                                ", given " + std::to_string(count));
  }
  sprout::SetThreads(count);
}

// Calls __new__ of the base. Python allows that only for the function of the class in which __new__
// was found, which is pybind11's base.
PyObject* NewOf(PyTypeObject* type, PyObject* arguments, PyObject* named) {
  return pybind11::detail::pybind11_object_new(type, arguments, named);
}

// Makes CLASS.__new__(CLASS) a TypeError, for every class of the module: pybind11 would give an
// object without a value, whose every use reads memory that was never written. CLASS(...) works as
// ever. copy.copy() calls __new__ too, so what can be copied or pickled has __reduce__.
void RefuseNew(pybind11::module_& module) {
  for (const auto& [name, value] : pybind11::dict(module.attr("__dict__"))) {
    if (!pybind11::isinstance<pybind11::type>(value) ||
        pybind11::detail::get_type_info(reinterpret_cast<PyTypeObject*>(value.ptr())) == nullptr) {
      continue;
    }
    reinterpret_cast<PyTypeObject*>(value.ptr())->tp_new = &NewOf;
  }
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
  // The module reports by Python's exceptions and warnings. Only run() logs, and sets the level.
  sprout::SetLogLevel(sprout::LogLevel::kNone);
  RefuseNew(module);
  python::WatchForTheEnd();
}
