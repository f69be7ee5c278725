#include "services/python/gil.h"

#include <unistd.h>

#include <atomic>
#include <chrono>
#include <thread>

namespace sprout::python {
namespace {

namespace py = pybind11;

std::atomic<bool> ending = false;
std::atomic<int> taking = 0;      // threads between the look at `ending` and having the lock
std::thread::id ending_thread{};  // set before `ending`

// Counts a thread that waits for the lock. When the interpreter ends the constructor never returns.
class Taking {
 public:
  Taking() {
    ++taking;
    if (!IsEnding()) return;
    --taking;
    while (true) pause();
  }
  ~Taking() { --taking; }
  Taking(const Taking&) = delete;
  Taking& operator=(const Taking&) = delete;
};

// Runs before Python ends its threads. Threads that wait for the lock already still get it.
void End() {
  constexpr std::chrono::milliseconds kPeriod{1};
  ending_thread = std::this_thread::get_id();
  ending = true;
  PyThreadState* const state = PyEval_SaveThread();
  while (taking > 0) std::this_thread::sleep_for(kPeriod);
  PyEval_RestoreThread(state);
}

}  // namespace

bool IsEnding() { return ending && std::this_thread::get_id() != ending_thread; }

Unlocked::Unlocked() : state_(PyEval_SaveThread()) {}

Unlocked::~Unlocked() {
  const Taking turn;
  PyEval_RestoreThread(state_);
}

Locked::Locked() {
  const Taking turn;
  state_ = PyGILState_Ensure();
}

Locked::~Locked() { PyGILState_Release(state_); }

void WatchForTheEnd() {
  // Python waits for all but daemon threads before it calls this.
  py::module_::import("atexit").attr("register")(py::cpp_function(&End));
}

}  // namespace sprout::python
