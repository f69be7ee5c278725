#pragma once

#include <string>

#include "services/tools/batch/result_folder.h"

namespace sprout::batch {

/// How logs are computed on this machine.
struct LocalOptions {
  int jobs = 0;     ///< logs at a time; 0 = one a core
  int retries = 2;  ///< further tries of a log that failed
};

/// Runs `PROGRAM compute` for every missing log, `jobs` at a time, until all are done or have
/// failed too often, or until Ctrl-C. Where there are fewer logs than cores a stage gets several
/// threads. Shows progress on a terminal, and failures on stderr.
/// @throws Interrupted after Ctrl-C, when all ended; std::runtime_error when a log failed for a
///         reason that concerns all: full disk, replaced program.
void RunLocal(const std::string& program, const BatchFolder& folder, const BatchState& state,
              const LocalOptions& options);

/// Options for Slurm.
struct SlurmOptions {
  std::string partition;          ///< empty: the cluster's default
  std::string memory = "2G";      ///< of a task
  std::string time = "04:00:00";  ///< a task at most
  int array_size = 1000;          ///< most tasks; at most Slurm's MaxArraySize
  int retries = 2;                ///< further rounds for failed logs
};

/// Submits a job array for the missing logs, each task one core and one log (or its share, where
/// there are more logs than tasks), and a job that runs when it has ended: `PROGRAM finish`, which
/// submits what is missing again. Does not wait for them.
/// @returns one line for people. @throws ConfigError when Slurm refuses.
std::string SubmitSlurm(const std::string& program, const BatchFolder& folder,
                        const BatchState& state, const SlurmOptions& options, int round);

/// Jobs of the batch that Slurm still has, "12,13"; empty: none, or no Slurm here.
std::string ActiveJobs(const BatchFolder& folder);

/// How many tasks of these jobs are in which state, and why: "2 RUNNING, 1 PENDING (Dependency)".
/// Slurm counts tasks of an array that wait for the same as one.
std::string StatesOfJobs(const std::string& jobs);

/// The newest output file of a task that printed something, with its last line; empty: there is
/// none. A task that works prints nothing; one whose program is missing prints an error.
std::string TaskOutput(const BatchFolder& folder);

}  // namespace sprout::batch
