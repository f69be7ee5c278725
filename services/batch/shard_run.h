#ifndef SPROUT_SERVICES_BATCH_SHARD_RUN_H_
#define SPROUT_SERVICES_BATCH_SHARD_RUN_H_

#include <stdexcept>
#include <string>

#include "services/batch/manifest.h"
#include "services/batch/result_folder.h"

namespace sprout::batch {

/// A stage failed on a shard. what() is one line; its output is in failed/ of the batch.
class ShardError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Files of a result, beside the stages' logs, and of a comparison.
inline constexpr char kMeasures[] = "measures.csv";
inline constexpr char kRuns[] = "run.json";
inline constexpr char kChanges[] = "changes.csv";

/// Whether all results of a shard exist and pass `check`.
bool IsDone(const BatchFolder& folder, const BatchHead& head, const BatchLog& log,
            const Shard& shard, ResultCheck check);

/// Computes the missing results of a shard: copies its events from the log, runs the stages on them
/// (one thread each), measures their answers, compares the variants. Results are renamed into place
/// when complete, so concurrent or killed processes do no harm.
/// @throws ShardError, LogError; ConfigError when a program differs from the manifest's.
void RunShard(const BatchFolder& folder, size_t number);

/// Program and what --version says. @throws ConfigError when it cannot be started.
StageProgram DescribeProgram(const std::string& path);

}  // namespace sprout::batch

#endif  // SPROUT_SERVICES_BATCH_SHARD_RUN_H_
