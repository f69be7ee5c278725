#ifndef SPROUT_SERVICES_BATCH_SHARD_INPUT_H_
#define SPROUT_SERVICES_BATCH_SHARD_INPUT_H_

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "services/batch/frame_lookup.h"
#include "services/batch/manifest.h"
#include "services/batch/scratch_file.h"

namespace sprout::batch {

/// The messages of a shard, as a log that stages can replay.
class ShardInput {
 public:
  /// @param channels  that the stages take.
  /// @throws LogError when log or index are not those of the manifest any more.
  ShardInput(const ShardOfBatch& work, const std::vector<std::string>& channels);

  /// A list of the events for programs that can read one (EventList), which then read the log
  /// itself; a copy of the events for others, of older builds. @throws LogError, no room for it.
  std::string Path(bool as_list);

  /// Whether a program can read a list: it then has the word that begins one among its bytes.
  static bool ReadsLists(std::string_view program_bytes);

  /// Adds the places of the messages.
  void AddTo(FrameLookup& frames) const;

  /// @throws LogError when the log is not the one of the manifest any more.
  void RequireUnchanged() const;

 private:
  [[noreturn]] void Changed() const;
  void WriteList(const std::string& path) const;
  void WriteCopy(const std::string& path) const;

  const ShardOfBatch& work_;
  std::vector<IndexedEvent> events_;  // in order; times go forward
  std::unique_ptr<ScratchFile> list_;
  std::unique_ptr<ScratchFile> copy_;
};

}  // namespace sprout::batch

#endif  // SPROUT_SERVICES_BATCH_SHARD_INPUT_H_
