#ifndef SPROUT_SERVICES_BATCH_SHARD_INPUT_H_
#define SPROUT_SERVICES_BATCH_SHARD_INPUT_H_

#include <string>
#include <vector>

#include "services/batch/frame_lookup.h"
#include "services/batch/manifest.h"
#include "services/batch/scratch_file.h"

namespace sprout::batch {

/// A copy of the messages of a shard, as a log that stages can replay.
class ShardInput {
 public:
  /// @param channels  that the stages take.
  /// @throws LogError when log or index have changed since the manifest, or there is no space for
  ///         the copy.
  ShardInput(const ShardOfBatch& work, const std::vector<std::string>& channels);

  std::string path() const { return copy_.path(); }

  /// Adds the positions of the messages.
  void AddTo(FrameLookup& frames) const;

  /// @throws LogError when the log has changed since the manifest.
  void RequireUnchanged() const;

 private:
  [[noreturn]] void Changed() const;
  void WriteCopy() const;

  const ShardOfBatch& work_;
  std::vector<IndexedEvent> events_;  // in order of time
  ScratchFile copy_;
};

}  // namespace sprout::batch

#endif  // SPROUT_SERVICES_BATCH_SHARD_INPUT_H_
