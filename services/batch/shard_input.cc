#include "services/batch/shard_input.h"

#include <algorithm>

#include "common/logfile/event_fetcher.h"
#include "common/logfile/log_writer.h"

namespace sprout::batch {

ShardInput::ShardInput(const ShardOfBatch& work, const std::vector<std::string>& channels)
    : work_(work) {
  std::vector<IndexedEvent> own;
  for (IndexedEvent& event : ReadIndexLines(work.log.index, work.shard.begin, work.shard.end)) {
    const bool is_taken =
        std::find(channels.begin(), channels.end(), event.channel) != channels.end();
    if (is_taken) own.push_back(std::move(event));
  }
  for (const int64_t line : work.shard.carried) {
    events_.push_back(ReadIndexLine(work.log.index, line));
  }
  if (own.empty() || InputDigest(events_, own) != work.shard.input) Changed();
  RequireUnchanged();
  // The first calibration may come from further behind, and would hold back what follows it.
  const auto oldest = std::min_element(
      own.begin(), own.end(),
      [](const IndexedEvent& x, const IndexedEvent& y) { return x.utime < y.utime; });
  for (IndexedEvent& event : events_) event.utime = std::min(event.utime, oldest->utime);
  events_.insert(events_.end(), own.begin(), own.end());
  WriteCopy();
}

void ShardInput::AddTo(FrameLookup& frames) const { frames.Add(work_.log.path, events_); }

void ShardInput::RequireUnchanged() const {
  if (!(StampOf(work_.log.path) == work_.log.summary.stamp)) Changed();
}

void ShardInput::Changed() const {
  throw LogError(work_.log.path,
                 "it or its index has changed since the batch was planned; run sprout-batch run "
                 "again");
}

void ShardInput::WriteCopy() const {
  EventFetcher fetcher(work_.log.path);
  LogWriter writer(path());
  for (const IndexedEvent& event : events_) {
    writer.Write(event.utime, event.channel, fetcher.Fetch(event.offset).data);
  }
  writer.Close();
}

}  // namespace sprout::batch
