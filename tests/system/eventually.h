#ifndef SPROUT_TESTS_SYSTEM_EVENTUALLY_H_
#define SPROUT_TESTS_SYSTEM_EVENTUALLY_H_

#include <chrono>
#include <functional>
#include <string>
#include <thread>

#include "common/app/process.h"

namespace sprout {

/// Waits for a condition that no message of the graph tells of; false after `timeout`.
inline bool Eventually(const std::function<bool()>& condition,
                       std::chrono::seconds timeout = std::chrono::seconds(30)) {
  const auto deadline = std::chrono::steady_clock::now() + timeout;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return true;
}

/// Waits until a process has written that.
inline bool Says(Process& process, const std::string& text) {
  return Eventually([&] { return process.Output().find(text) != std::string::npos; });
}

}  // namespace sprout

#endif  // SPROUT_TESTS_SYSTEM_EVENTUALLY_H_
