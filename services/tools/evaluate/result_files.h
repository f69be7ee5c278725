#ifndef SPROUT_SERVICES_TOOLS_EVALUATE_RESULT_FILES_H_
#define SPROUT_SERVICES_TOOLS_EVALUATE_RESULT_FILES_H_

#include <string>
#include <vector>

#include "services/tools/evaluate/evaluate.h"

namespace sprout::evaluate {

/// Settings and results of a run.
struct RunResult {
  std::string preset;  ///< names of the configuration files, joined by '+'
  std::string tof;     ///< --tof
  std::vector<SceneResult> scenes;
};

// Both depend on the run's input only, except for the times, which are under "ms" and in columns
// that end in _ms. Shares are per cent; an undefined value (the mean error of an empty map) is null
// or an empty field. See README.md for the layout.

std::string ToJson(const RunResult& run);
std::string ToCsv(const RunResult& run);

}  // namespace sprout::evaluate

#endif  // SPROUT_SERVICES_TOOLS_EVALUATE_RESULT_FILES_H_
