#ifndef SPROUT_SERVICES_EVALUATE_RESULT_FILES_H_
#define SPROUT_SERVICES_EVALUATE_RESULT_FILES_H_

#include <string>
#include <vector>

#include "services/evaluate/evaluate.h"

namespace sprout::evaluate {

/// What a whole run found, and with what.
struct RunResult {
  std::string preset;  ///< names of the configuration files, joined by '+'
  std::string tof;     ///< --tof
  std::vector<SceneResult> scenes;
};

// Both depend on the run's input only, except for the times, which are under "ms" and in columns
// that end in _ms. Shares are per cent; what has no value (the mean error of an empty map) is null
// or an empty field. See README.md for the layout.

std::string ToJson(const RunResult& run);
std::string ToCsv(const RunResult& run);

}  // namespace sprout::evaluate

#endif  // SPROUT_SERVICES_EVALUATE_RESULT_FILES_H_
