#ifndef SPROUT_TESTS_SYSTEM_PROCESS_H_
#define SPROUT_TESTS_SYSTEM_PROCESS_H_

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace sprout {

/// A program started by a test; its output goes to a file. Killed when the object goes.
class Process {
 public:
  /// @param command  program and arguments.
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

/// Path of one of our programs, "sprout-grow".
std::string ProgramPath(const std::string& name);

}  // namespace sprout

#endif  // SPROUT_TESTS_SYSTEM_PROCESS_H_
