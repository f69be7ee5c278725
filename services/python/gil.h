#pragma once

#include <pybind11/pybind11.h>

namespace sprout::python {

// The interpreter's lock, given back and taken. While the interpreter ends, Python ends every other
// thread that takes it, by an unwinding that C++ answers with abort() in any destructor. So nobody
// takes the lock then: daemon threads stand still until the process is gone, as they do in Python
// 3.14 and later. Used everywhere in place of pybind11's gil_scoped_release and gil_scoped_acquire.

/// Releases the interpreter's lock while it lives, for long work. The thread that creates it has
/// the lock.
class Unlocked {
 public:
  Unlocked();
  ~Unlocked();
  Unlocked(const Unlocked&) = delete;
  Unlocked& operator=(const Unlocked&) = delete;

 private:
  PyThreadState* state_;
};

/// Holds the interpreter's lock while it lives, in any thread, also in one that has it already.
class Locked {
 public:
  Locked();
  ~Locked();
  Locked(const Locked&) = delete;
  Locked& operator=(const Locked&) = delete;

 private:
  PyGILState_STATE state_;
};

/// Whether the interpreter ends, so that nothing more may take the lock.
bool IsEnding();

/// Makes threads wait for ever instead of taking the lock once the interpreter ends. Called once,
/// by the module.
void WatchForTheEnd();

}  // namespace sprout::python
