#ifndef SPROUT_COMMON_APP_PROCESS_H_
#define SPROUT_COMMON_APP_PROCESS_H_

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace sprout {

/// A program that this one starts; its output goes to a file. Killed when the object goes.
class Process {
 public:
  /// @param command  program, looked for in PATH, and arguments. A program that cannot be started
  ///                 ends with exit code 127.
  /// @throws std::runtime_error when the machine has no process or temporary file left.
  explicit Process(const std::vector<std::string>& command);
  ~Process();

  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  void Signal(int signal);

  /// Waits until the process ends.
  /// @returns its exit code, 128 + the signal that killed it; nothing when it still runs after
  ///          `timeout`.
  std::optional<int> Wait(std::chrono::seconds timeout = std::chrono::seconds(30));

  /// What it wrote to stdout and stderr so far.
  std::string Output() const;

 private:
  pid_t pid_ = -1;
  std::optional<int> exit_code_;
  std::filesystem::path output_;
};

}  // namespace sprout

#endif  // SPROUT_COMMON_APP_PROCESS_H_
