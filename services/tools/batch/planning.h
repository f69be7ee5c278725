#ifndef SPROUT_SERVICES_TOOLS_BATCH_PLANNING_H_
#define SPROUT_SERVICES_TOOLS_BATCH_PLANNING_H_

#include <string>
#include <vector>

#include "services/tools/batch/manifest.h"

namespace sprout::batch {

/// The options of a run.
struct BatchRequest {
  std::vector<std::string> inputs;  ///< logs, folders of logs (*.lcm), @LIST files
  std::string out;
  std::vector<std::string> stages = {"refine", "prior", "grow"};
  std::vector<std::string> keep;      ///< empty: the last stage
  std::vector<std::string> config_a;  ///< as --config of the services
  std::vector<std::string> config_b;  ///< empty: that of A, if there is a B
  std::string programs_a;             ///< folder of the programs
  std::string programs_b;             ///< empty: that of A, if there is a B
  std::string truth;
  bool no_measures = false;  ///< the quality of frames is not measured
  std::string prefix;
};

/// One line on stderr for each log that is left out.
void SayLeftOut(const Manifest& manifest);

/// The manifest of a request, written to its folder with the effective configurations. Reads each
/// new or changed log once, for its digest. An equal manifest is kept.
/// @param program  path of sprout-batch.
/// @throws ConfigError, LogError.
Manifest Plan(const BatchRequest& request, const std::string& program);

}  // namespace sprout::batch

#endif  // SPROUT_SERVICES_TOOLS_BATCH_PLANNING_H_
