#ifndef SPROUT_COMMON_CORE_SIGNAL_WATCHER_H_
#define SPROUT_COMMON_CORE_SIGNAL_WATCHER_H_

#include <chrono>
#include <csignal>
#include <functional>
#include <stop_token>
#include <thread>

namespace sprout {

/// Requests a stop when SIGINT or SIGTERM comes, for programs that wait for something; Interrupt is
/// for loops that only compute. The signals are blocked in every thread and taken by one that waits
/// for them, so that no code runs in a signal handler. A second signal is the kernel's: it ends the
/// process whatever its threads are stuck in, a FIFO that nobody writes, a server that takes no
/// more, a long computation. So is SIGALRM after the grace period. To be made before other threads:
/// those that were there already (a library's, in somebody else's program) pass on what they are
/// given until the first signal.
class SignalWatcher {
 public:
  /// @param grace  how long the process has to end by itself; 0: as long as it takes.
  /// @param told   is called with the signal, after the request, by the watcher's thread.
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

}  // namespace sprout

#endif  // SPROUT_COMMON_CORE_SIGNAL_WATCHER_H_
