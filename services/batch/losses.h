#ifndef SPROUT_SERVICES_BATCH_LOSSES_H_
#define SPROUT_SERVICES_BATCH_LOSSES_H_

#include <cstdint>
#include <vector>

#include "services/batch/merge.h"

namespace sprout::batch {

/// What did not go through, of a log or of all. Counts of frames and messages are of the log;
/// `variants` knows only the shards that are done.
struct Losses {
  /// What a variant made of the frames.
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
  int64_t incomplete = 0;   ///< a message of them never came
  int64_t left_out = 0;     ///< frame numbers that nothing in the log has
  int64_t undecodable = 0;  ///< messages of the graph's channels that no stage would take
  int64_t damaged_bytes = 0;
  std::vector<OfVariant> variants;

  void Add(const Losses& other);

  /// Whether anything is lost or was difficult.
  bool Any() const;
};

/// The losses of each log. Reads the counts of every shard that is done: O(shards).
/// @throws LogError.
std::vector<Losses> LossesOf(const BatchFolder& folder, const Manifest& manifest,
                             const BatchState& state);

}  // namespace sprout::batch

#endif  // SPROUT_SERVICES_BATCH_LOSSES_H_
