#ifndef SPROUT_SERVICES_BATCH_SHARD_RUN_H_
#define SPROUT_SERVICES_BATCH_SHARD_RUN_H_

#include <stdexcept>
#include <string>

#include "services/batch/manifest.h"
#include "services/batch/result_folder.h"

namespace sprout::batch {

/// A stage that failed over a shard. what() is one line; its output is in failed/ of the batch.
class ShardError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Files of a result, beside the stages' logs, and of a comparison.
inline constexpr char kMeasures[] = "measures.csv";
inline constexpr char kRuns[] = "run.json";
inline constexpr char kChanges[] = "changes.csv";

/// Whether all results of a shard are there, and whole as far as `check` looks.
bool IsDone(const BatchFolder& folder, const BatchHead& head, const BatchLog& log,
            const Shard& shard, ResultCheck check);

/// Computes what is missing of a shard: cuts its frames out of the log, runs the stages over them
/// (one thread each), measures what they answered, compares the variants. Results appear whole or
/// not at all, so several processes, and ones that are killed, do no harm.
/// @throws ShardError, LogError; ConfigError when a program is not the one of the manifest.
void RunShard(const BatchFolder& folder, size_t number);

/// Program and what --version says. @throws ConfigError when it cannot be started.
StageProgram DescribeProgram(const std::string& path);

}  // namespace sprout::batch

#endif  // SPROUT_SERVICES_BATCH_SHARD_RUN_H_
