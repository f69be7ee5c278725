#ifndef SPROUT_SERVICES_TOOLS_BATCH_COMMANDS_H_
#define SPROUT_SERVICES_TOOLS_BATCH_COMMANDS_H_

#include <cstdint>
#include <string>
#include <vector>

#include "services/tools/batch/engines.h"
#include "services/tools/batch/planning.h"

namespace sprout::batch {

/// The flags of all commands.
struct Options {
  BatchRequest request;
  std::string engine = "local";
  LocalOptions local;
  SlurmOptions slurm;
  std::string out;
  std::vector<uint64_t> logs;  ///< numbers
  int threads = 1;
  int round = 0;
};

// The commands. Each returns the program's exit code.
// @throws ConfigError, LogError, Interrupted, std::runtime_error.
int RunRun(Options& options);
int RunCompute(const Options& options);
int RunFinish(const Options& options);
int RunStatus(const Options& options);
int RunReport(const Options& options);

}  // namespace sprout::batch

#endif  // SPROUT_SERVICES_TOOLS_BATCH_COMMANDS_H_
