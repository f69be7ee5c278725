#ifndef SPROUT_SERVICES_BATCH_LOSSES_H_
#define SPROUT_SERVICES_BATCH_LOSSES_H_

#include <cstdint>
#include <vector>

#include "services/batch/merge.h"

namespace sprout::batch {

/// Losses in a log or in all logs. Counts of frames and messages are of the log; `variants` covers
/// only finished shards.
struct Losses {
  /// Results of a variant.
  struct OfVariant {
    int64_t unanswered = 0;  ///< complete, but without an answer
    int64_t empty = 0;       ///< answered with an empty map
    int64_t refused = 0;     ///< messages that a stage refused
  };

  int64_t shards = 0;
  int64_t retried = 0;      ///< done, but not at the first try
  int64_t failed = 0;       ///< not done although tried
  int64_t untried = 0;      ///< not done, not tried
  int64_t frames = 0;       ///< complete in the log
  int64_t incomplete = 0;   ///< a message is missing
  int64_t left_out = 0;     ///< frame numbers missing in the log
  int64_t undecodable = 0;  ///< messages of the graph's channels that stages refuse
  int64_t damaged_bytes = 0;
  std::vector<OfVariant> variants;

  void Add(const Losses& other);

  /// Whether anything was lost or had to be retried.
  bool Any() const;
};

/// The losses of each log. Reads the counts of every shard that is done: O(shards).
/// @throws LogError.
std::vector<Losses> LossesOf(const BatchFolder& folder, const Manifest& manifest,
                             const BatchState& state);

}  // namespace sprout::batch

#endif  // SPROUT_SERVICES_BATCH_LOSSES_H_
