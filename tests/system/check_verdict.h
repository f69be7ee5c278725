#ifndef SPROUT_TESTS_SYSTEM_CHECK_VERDICT_H_
#define SPROUT_TESTS_SYSTEM_CHECK_VERDICT_H_

#include <sstream>
#include <string>
#include <vector>

#include "tests/system/graph.h"
#include "tests/system/log_bytes.h"

namespace sprout {

/// What sprout-check-stage says about a program, on the network that the test runs in.
struct Verdict {
  int exit_code;
  std::vector<std::string> wrong;  ///< its lines that begin with WRONG
  std::string output;
};

/// @param arguments  flags and the name of the stage.
/// @param command    the program that is checked.
inline Verdict Check(const std::vector<std::string>& arguments,
                     const std::vector<std::string>& command) {
  std::vector<std::string> check = {ProgramPath("sprout-check-stage")};
  check.insert(check.end(), arguments.begin(), arguments.end());
  check.push_back("--");
  check.insert(check.end(), command.begin(), command.end());
  Process process(check);
  Verdict verdict{.exit_code = process.Wait(std::chrono::seconds(240)).value_or(-1),
                  .wrong = {},
                  .output = process.Output()};
  std::istringstream lines(verdict.output);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("WRONG")) verdict.wrong.push_back(line);
  }
  return verdict;
}

}  // namespace sprout

#endif  // SPROUT_TESTS_SYSTEM_CHECK_VERDICT_H_
