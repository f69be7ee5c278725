#pragma once

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <string>
#include <thread>

#include "common/app/process.h"

namespace sprout {

/// Path of one of our programs, "sprout-grow".
inline std::string ProgramPath(const std::string& name) {
  return (std::filesystem::path(SPROUT_BINARY_DIR) / name).string();
}

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

/// A file of a process in /proc; empty when it has ended.
inline std::string ProcText(pid_t pid, const std::string& name) {
  std::ifstream file("/proc/" + std::to_string(pid) + "/" + name);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Whether a process takes a signal; before, the signal would just end it.
inline bool Catches(pid_t pid, int signal) {
  const std::string status = ProcText(pid, "status");
  const size_t caught = status.find("SigCgt:");
  if (caught == std::string::npos) return false;
  return (std::stoull(status.substr(caught + 7), nullptr, 16) >> (signal - 1) & 1) != 0;
}

/// Peak of the memory of a process, MB; 0 when it has ended.
inline int64_t PeakMegabytes(pid_t pid) {
  const std::string status = ProcText(pid, "status");
  const size_t peak = status.find("VmHWM:");
  return peak == std::string::npos ? 0 : std::stoll(status.substr(peak + 6)) / 1024;
}

/// Waits until a process has written that.
inline bool Says(Process& process, const std::string& text) {
  return Eventually([&] { return process.Output().find(text) != std::string::npos; });
}

}  // namespace sprout
