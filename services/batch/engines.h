#ifndef SPROUT_SERVICES_BATCH_ENGINES_H_
#define SPROUT_SERVICES_BATCH_ENGINES_H_

#include <cstdint>
#include <string>
#include <vector>

#include "services/batch/merge.h"

namespace sprout::batch {

/// How shards are computed on this machine.
struct LocalOptions {
  int jobs = 0;     ///< shards at a time; 0 = one a core
  int retries = 2;  ///< further tries of a shard that failed
};

/// Runs `PROGRAM run-shard` for every missing shard, `jobs` at a time, until all are done or have
/// failed too often, or until Ctrl-C. Shows progress on a terminal, and failures on stderr.
/// @returns shards that are still missing. @throws Interrupted after Ctrl-C, when all ended;
///          std::runtime_error when a shard failed for a reason that concerns all: full disk,
///          replaced program.
int64_t RunLocal(const std::string& program, const BatchFolder& folder, const Manifest& manifest,
                 const BatchState& state, const LocalOptions& options);

/// Options for Slurm.
struct SlurmOptions {
  std::string partition;          ///< empty: the cluster's default
  std::string memory = "2G";      ///< of a task
  std::string time = "04:00:00";  ///< a task at most
  int array_size = 1000;          ///< most tasks; at most Slurm's MaxArraySize
  int retries = 2;                ///< further rounds for failed shards
};

/// Submits one job array for the missing shards, each task one core and its share of the shards; a
/// job for the merge, which submits missing shards again; and a job for the report. Does not wait
/// for them.
/// @returns one line for people. @throws ConfigError when Slurm refuses, or when jobs of this batch
///          are still running.
std::string SubmitSlurm(const std::string& program, const BatchFolder& folder,
                        const BatchState& state, const SlurmOptions& options, int round);

/// Jobs of the batch that Slurm still has, "12,13"; empty: none, or no Slurm here.
std::string ActiveJobs(const BatchFolder& folder);

/// Removes what killed processes left: folders that were not renamed yet.
void RemoveParts(const BatchFolder& folder);

}  // namespace sprout::batch

#endif  // SPROUT_SERVICES_BATCH_ENGINES_H_
