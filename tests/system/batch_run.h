#ifndef SPROUT_TESTS_SYSTEM_BATCH_RUN_H_
#define SPROUT_TESTS_SYSTEM_BATCH_RUN_H_

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "tests/system/eventually.h"

namespace sprout {

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

/// Three stages over all logs of a folder.
inline std::vector<std::string> RunCommand(const std::filesystem::path& logs,
                                           const std::filesystem::path& out) {
  return {"sprout-batch",     "run", logs, "--out", out, "--config", "fast", "--keep",
          "refine,prior,grow"};
}

/// The cells of a column of frames.csv; NaN where they are empty.
inline std::vector<double> ColumnOf(const std::filesystem::path& out, const std::string& name) {
  std::ifstream file(out / "frames.csv");
  std::vector<double> column;
  std::ptrdiff_t at = -1;
  for (std::string line; std::getline(file, line);) {
    std::vector<std::string> cells;
    std::istringstream rest(line);
    for (std::string cell; std::getline(rest, cell, ',');) cells.push_back(cell);
    if (at < 0) {
      at = std::ranges::find(cells, name) - cells.begin();
      EXPECT_LT(at, std::ssize(cells)) << "no column " << name;
    } else {
      const std::string cell = at < std::ssize(cells) ? cells[static_cast<size_t>(at)] : "";
      column.push_back(cell.empty() ? std::nan("") : std::stod(cell));
    }
  }
  return column;
}

}  // namespace sprout

#endif  // SPROUT_TESTS_SYSTEM_BATCH_RUN_H_
