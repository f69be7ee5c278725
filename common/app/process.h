#pragma once

#include <sys/types.h>

#include <chrono>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace sprout {

/// A program started by this one. It and the programs that it starts (its process group) are killed
/// when it has ended, when the object is destroyed, and when this program ends in any way, even by
/// SIGKILL.
class Process {
 public:
  /// Most output that is kept, bytes.
  static constexpr size_t kOutputBytes = size_t{1} << 20;

  /// @param command  program, searched in PATH, and arguments. If it cannot be started the exit
  ///                 code is 127.
  /// @throws std::runtime_error when no process or pipe can be created.
  explicit Process(const std::vector<std::string>& command);
  ~Process();

  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  /// Process id of the program.
  pid_t pid() const { return pid_; }

  void Signal(int signal);

  /// Waits until the process ends.
  /// @returns its exit code, 128 + the signal that killed it; nothing when it still runs after
  ///          `timeout`.
  std::optional<int> Wait(std::chrono::milliseconds timeout = std::chrono::seconds(30));

  /// What it wrote to stdout and stderr so far; at most the last megabyte.
  std::string Output();

 private:
  void ReadOutput();

  pid_t pid_ = -1;
  std::optional<int> exit_code_;
  pid_t guard_pid_ = -1;  // kills the program when life_pipe_ closes before it has ended
  int life_pipe_ = -1;
  int output_pipe_ = -1;
  std::mutex mutex_;
  std::string output_;
  std::jthread reader_;  // last: stops before the rest is destroyed
};

}  // namespace sprout
