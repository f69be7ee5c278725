#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/system/eventually.h"
#include "tests/system/log_bytes.h"

namespace sprout {

struct Outcome {
  int exit_code;  ///< -1: it still ran when nobody waited any longer
  std::string output;
};

/// Runs a program to its end.
/// @param words  one of ours, "sprout-grow", or any other program, and its arguments.
inline Outcome RunProgramOf(std::vector<std::string> words,
                            std::chrono::seconds timeout = std::chrono::seconds(240)) {
  if (words[0].starts_with("sprout-")) words[0] = ProgramPath(words[0]);
  Process process(words);
  const int code = process.Wait(timeout).value_or(-1);
  return {code, process.Output()};
}

/// What a run writes that ends with this exit code.
inline std::string OutputOf(const std::vector<std::string>& words, int exit_code = 0,
                            std::chrono::seconds timeout = std::chrono::seconds(30)) {
  const Outcome outcome = RunProgramOf(words, timeout);
  EXPECT_EQ(outcome.exit_code, exit_code) << outcome.output;
  return outcome.output;
}

/// Replays logs through a program. @returns what it wrote.
/// @param record  gets its answers.
inline std::string Replay(const std::string& program, const std::string& config,
                          const std::vector<std::filesystem::path>& logs,
                          const std::filesystem::path& record) {
  std::vector<std::string> command = {program, "--config", config, "--record", record};
  for (const auto& log : logs) command.insert(command.end(), {"--replay", log});
  return OutputOf(command, 0, std::chrono::seconds(60));
}

}  // namespace sprout
