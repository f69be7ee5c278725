#ifndef SPROUT_TESTS_SYSTEM_BATCH_RUN_H_
#define SPROUT_TESTS_SYSTEM_BATCH_RUN_H_

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include "common/app/process.h"

namespace sprout {

inline std::string ProgramPath(const std::string& name) {
  return (std::filesystem::path(SPROUT_BINARY_DIR) / name).string();
}

struct Outcome {
  int exit_code;
  std::string output;
};

/// Runs a program of this build to its end.
/// @param before  what starts the program, with arguments.
inline Outcome RunProgramOf(const std::vector<std::string>& words,
                            const std::vector<std::string>& before = {}) {
  std::vector<std::string> command = before;
  command.insert(command.end(), words.begin(), words.end());
  command[before.size()] = ProgramPath(words[0]);
  Process process(command);
  const int code = process.Wait(std::chrono::seconds(240)).value_or(-1);
  return {code, process.Output()};
}

/// Three stages over all logs of a folder, in small shards.
inline std::vector<std::string> RunCommand(const std::filesystem::path& logs,
                                           const std::filesystem::path& out) {
  return {"sprout-batch",
          "run",
          logs,
          "--out",
          out,
          "--config",
          "fast",
          "--keep",
          "refine,prior,grow",
          "--shard-megabytes",
          "1"};
}

}  // namespace sprout

#endif  // SPROUT_TESTS_SYSTEM_BATCH_RUN_H_
