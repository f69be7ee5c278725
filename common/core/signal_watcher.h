#pragma once

#include <chrono>
#include <csignal>
#include <functional>
#include <stdexcept>
#include <stop_token>
#include <thread>

namespace sprout {

/// Requests a stop when SIGINT or SIGTERM comes, or SIGHUP (the terminal is gone) unless it is
/// ignored already, for programs that wait for something; Interrupt is for loops that only compute.
/// The signals are blocked in every thread and received by one that waits for them, so no code of
/// the program runs in a signal handler. A second SIGINT or SIGTERM, a tenth of a second later or
/// more, has the kernel's default action: it ends the process even if its threads hang in a read, a
/// write or a long computation.
/// So does SIGALRM after the grace period. Create it before other threads; those that exist already
/// (a library's, in somebody else's program) pass on the first signal.
class SignalWatcher {
 public:
  /// @param grace  time for the process to end by itself; 0: unlimited.
  /// @param told   called with the signal, after the request, by the watcher's thread.
  explicit SignalWatcher(std::chrono::microseconds grace = {}, std::function<void(int)> told = {});
  ~SignalWatcher();
  SignalWatcher(const SignalWatcher&) = delete;
  SignalWatcher& operator=(const SignalWatcher&) = delete;

  std::stop_token token() const { return source_.get_token(); }

 private:
  void Watch(const std::stop_token& stop);

  std::chrono::microseconds grace_;
  std::function<void(int)> told_;
  sigset_t signals_{};
  std::stop_source source_;
  std::jthread thread_;
};

/// Ctrl-C. While it is thrown incomplete files are removed; complete ones stay.
class Interrupted : public std::runtime_error {
 public:
  Interrupted() : std::runtime_error("interrupted") {}
};

/// Records SIGINT and SIGTERM while it exists; a second one, as above, ends the program at once.
/// Only one object at a time.
class Interrupt {
 public:
  Interrupt();
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

  static bool requested();

  /// Ends long loops. @throws Interrupted when a stop was requested.
  static void Check() {
    if (requested()) throw Interrupted();
  }
};

}  // namespace sprout
