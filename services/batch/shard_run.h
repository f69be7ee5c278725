#ifndef SPROUT_SERVICES_BATCH_SHARD_RUN_H_
#define SPROUT_SERVICES_BATCH_SHARD_RUN_H_

#include <cstdint>
#include <stdexcept>
#include <string>

#include "services/batch/manifest.h"

namespace sprout {

/// A shard that could not be computed. what() is one line; the output of the program that failed is
/// in failed/SHARD.txt of the batch.
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

/// Counts and times of the stages over one shard, kept beside its answers.
struct StageRun {
  int64_t frames_in = 0;
  int64_t frames_out = 0;
  int64_t degenerate = 0;  ///< answered, with an empty map
  int64_t failed = 0;      ///< not answered
  int64_t bad_messages = 0;
  double seconds = 0;  ///< wall time of the program, its start included
};

/// What a stage said at the end of a replay.
/// @throws ShardError when it did not say it.
StageRun ParseReplayReport(const std::string& output);

}  // namespace sprout

#endif  // SPROUT_SERVICES_BATCH_SHARD_RUN_H_
