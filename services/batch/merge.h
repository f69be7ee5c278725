#ifndef SPROUT_SERVICES_BATCH_MERGE_H_
#define SPROUT_SERVICES_BATCH_MERGE_H_

#include <cstdint>
#include <string>
#include <vector>

#include "services/batch/manifest.h"

namespace sprout::batch {

/// Progress of a batch.
struct BatchState {
  std::vector<bool> done;  ///< by shard
  int64_t missing = 0;
};

/// Checks every shard: whether its results exist and have their full sizes.
/// O(shards).
BatchState StateOf(const BatchFolder& folder, const Manifest& manifest);

/// The same, but reads every byte of the results that MergeLogs() uses. Damaged results do not
/// count as done, and lose their list of files, so that they are computed again; one line on stderr
/// each.
BatchState CheckedStateOf(const BatchFolder& folder, const Manifest& manifest);

/// Merges the answers of each log whose shards are all done into one log a variant, logs/NAME_a.lcm
/// and NAME_b.lcm: the bytes that a replay of the whole log on one machine records (of several
/// stages: their logs merged by `sprout-log merge`). Logs that are up to date stay.
/// @returns how many logs were written. @throws LogError.
int64_t MergeLogs(const BatchFolder& folder, const Manifest& manifest, const BatchState& state);

/// Writes frames.csv: a row for each frame of each shard that is done. @throws LogError.
void WriteFrameTable(const BatchFolder& folder, const Manifest& manifest, const BatchState& state);

}  // namespace sprout::batch

#endif  // SPROUT_SERVICES_BATCH_MERGE_H_
