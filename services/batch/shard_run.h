#ifndef SPROUT_SERVICES_BATCH_SHARD_RUN_H_
#define SPROUT_SERVICES_BATCH_SHARD_RUN_H_

#include <stdexcept>
#include <string>

#include "services/batch/manifest.h"

namespace sprout::batch {

/// A stage that failed over a shard. what() is one line; its output is in failed/ of the batch.
class ShardError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Whether all results of a shard are there. A few look-ups of names, no reading.
bool IsDone(const BatchFolder& folder, const BatchHead& head, const BatchLog& log,
            const Shard& shard);

/// Computes what is missing of a shard: cuts its frames out of the log, runs the stages over them
/// (one thread each), measures what they answered, compares the variants. Results appear whole or
/// not at all, so several processes, and ones that are killed, do no harm.
/// @throws ShardError, LogError; ConfigError when a program is not the one of the manifest.
void RunShard(const BatchFolder& folder, size_t number);

/// Program and what --version says. @throws ConfigError when it cannot be started.
StageProgram DescribeProgram(const std::string& path);

/// Digest of a file's bytes. @throws ConfigError when it cannot be read.
std::string FileDigest(const std::filesystem::path& path);

}  // namespace sprout::batch

#endif  // SPROUT_SERVICES_BATCH_SHARD_RUN_H_
