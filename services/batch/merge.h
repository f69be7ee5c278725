#ifndef SPROUT_SERVICES_BATCH_MERGE_H_
#define SPROUT_SERVICES_BATCH_MERGE_H_

#include <cstdint>
#include <string>
#include <vector>

#include "services/batch/manifest.h"

namespace sprout::batch {

/// What became of a batch.
struct BatchState {
  std::vector<bool> done;  ///< by shard
  int64_t missing = 0;
};

/// Looks at every shard: whether its results are there, and as long as they were written.
/// O(shards).
BatchState StateOf(const BatchFolder& folder, const Manifest& manifest);

/// The same, but reads every byte of the results that MergeLogs() would take. What is damaged does
/// not count as done, and loses its list of files, so that it is computed again; one line on stderr
/// each.
BatchState CheckedStateOf(const BatchFolder& folder, const Manifest& manifest);

/// Puts the answers of each log whose shards are all done into one log a variant, logs/NAME_a.lcm
/// and NAME_b.lcm: the bytes that a replay of the whole log on one machine records (of several
/// stages: their logs merged by `sprout-log merge`). What is up to date stays.
/// @returns how many logs were written. @throws LogError.
int64_t MergeLogs(const BatchFolder& folder, const Manifest& manifest, const BatchState& state);

/// Writes frames.csv: a row for each frame of each shard that is done. @throws LogError.
void WriteFrameTable(const BatchFolder& folder, const Manifest& manifest, const BatchState& state);

}  // namespace sprout::batch

#endif  // SPROUT_SERVICES_BATCH_MERGE_H_
