#ifndef SPROUT_SERVICES_BATCH_SHARD_PLAN_H_
#define SPROUT_SERVICES_BATCH_SHARD_PLAN_H_

#include <cstdint>
#include <string>
#include <vector>

#include "services/batch/log_index.h"
#include "services/batch/stage_chain.h"

namespace sprout::batch {

/// A stretch of a log that can be replayed on its own.
///
/// The state of a replay is small: the calibrations so far, and the parts of incomplete frames. A
/// shard begins with these messages (`carried`), so that its replay starts in the state that a
/// replay of the whole log has there; then come the messages of its own stretch. So the answers of
/// all shards, one after the other, are those of the whole log, also for frames across a cut. Cuts
/// lie where a frame has just been completed.
struct Shard {
  int64_t log = 0;               ///< number of its log in the manifest
  int64_t begin = 0;             ///< its lines in the index, bytes (IndexedEvent::line)
  int64_t end = 0;               ///< after the last one
  std::vector<int64_t> carried;  ///< lines of the messages that the replay holds at its beginning
  int64_t frames = 0;            ///< frames completed in it
  int64_t first_seq = 0;         ///< number of the first of them
  int64_t last_seq = 0;          ///< number of the last of them
  int64_t bytes = 0;             ///< of all its events
  std::string input;             ///< digest of all its events: channels, times and messages

  bool operator==(const Shard&) const = default;
};

/// How a log is cut.
struct PlanOptions {
  ChainInputs inputs;
  std::string prefix;       ///< of every channel
  int64_t shard_bytes = 0;  ///< approximate size of a shard; > 0
};

/// How a log is cut, and what is in no shard.
struct LogPlan {
  std::vector<Shard> shards;  ///< none when no frame is complete
  int64_t incomplete = 0;     ///< frames of which a message never came
  int64_t left_out = 0;       ///< frame numbers that the first stage's messages leave out
};

/// The shards of a log, and the counts that a replay of the first stage would report. A log is not
/// cut when an undecodable message makes its order uncertain (see LogIndex), or when the first
/// stage does not wait for all channels that later ones take from it. O(events · log(unfinished
/// frames)).
LogPlan PlanShards(const LogIndex& index, const PlanOptions& options);

/// The digest in Shard::input.
/// @param carried, own  the events of the shard, of the channels that its stages take.
std::string InputDigest(const std::vector<IndexedEvent>& carried,
                        const std::vector<IndexedEvent>& own);

/// The channels that a chain takes from a log.
std::vector<std::string> ChannelsOf(const ChainInputs& inputs, const std::string& prefix);

}  // namespace sprout::batch

#endif  // SPROUT_SERVICES_BATCH_SHARD_PLAN_H_
