#ifndef SPROUT_SERVICES_PYTHON_NEW_OBJECT_H_
#define SPROUT_SERVICES_PYTHON_NEW_OBJECT_H_

#include <pybind11/pybind11.h>

namespace sprout::python {

/// Makes CLASS.__new__(CLASS) a TypeError, for every class of the module: pybind11 would give an
/// object without a value, whose every use reads memory that was never written. CLASS(...) works as
/// ever. copy.copy() calls __new__ too, so what can be copied or pickled has __reduce__.
void RefuseNew(pybind11::module_& module);

}  // namespace sprout::python

#endif  // SPROUT_SERVICES_PYTHON_NEW_OBJECT_H_
