#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "common/app/progress.h"
#include "common/core/signal_watcher.h"
#include "common/logfile/log_reader.h"

namespace sprout::log {

/// Shows how much of the logs has been read, only on a terminal and a few times a second, and
/// throws on Ctrl-C. Only one object at a time.
class ReadProgress {
 public:
  /// @param what   what is being done, "reading run.lcm".
  /// @param bytes  size of all that will be read.
  ReadProgress(std::string what, int64_t bytes);

  /// @throws Interrupted after Ctrl-C.
  void Update(int64_t position);

  /// Erases the line, to make room for other output.
  void Clear() { line_.Clear(); }

 private:
  std::string what_;
  int64_t bytes_;
  std::chrono::steady_clock::time_point next_;
  Interrupt interrupt_;
  Progress line_{/*quiet=*/false};
};

/// One line for a stretch of damage: "bytes 100-163 (64): 1 event lost".
std::string DamageText(const LogDamage& damage);

/// One line when a log was damaged, for programs that continue; else nothing.
std::string DamageWarning(const std::filesystem::path& path, const std::vector<LogDamage>& damage);

/// Prints DamageWarning() to stderr, behind the program's name.
void WarnOfDamage(const std::filesystem::path& path, const std::vector<LogDamage>& damage);

}  // namespace sprout::log
