#include "services/python/new_object.h"

namespace sprout::python {
namespace {

namespace py = pybind11;

// What the base does. Python allows __new__ only where it is the very function of the class that
// __new__ was found in, and that is pybind11's base.
PyObject* NewOf(PyTypeObject* type, PyObject* arguments, PyObject* named) {
  return py::detail::pybind11_object_new(type, arguments, named);
}

}  // namespace

void RefuseNew(py::module_& module) {
  for (const auto& [name, value] : py::dict(module.attr("__dict__"))) {
    if (!py::isinstance<py::type>(value) ||
        py::detail::get_type_info(reinterpret_cast<PyTypeObject*>(value.ptr())) == nullptr) {
      continue;
    }
    reinterpret_cast<PyTypeObject*>(value.ptr())->tp_new = &NewOf;
  }
}

}  // namespace sprout::python
