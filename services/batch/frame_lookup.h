#ifndef SPROUT_SERVICES_BATCH_FRAME_LOOKUP_H_
#define SPROUT_SERVICES_BATCH_FRAME_LOOKUP_H_

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/core/frame.h"
#include "common/logfile/event_fetcher.h"
#include "services/batch/log_index.h"

namespace sprout::batch {

/// Finds the parts of frames in small logs, in any order. Opening reads where each message begins.
class FrameLookup {
 public:
  explicit FrameLookup(std::string prefix) : prefix_(std::move(prefix)) {}

  /// Adds the parts that a log has, which is one that a stage wrote, and so is whole. Of a part
  /// that comes again, the newest counts. @throws LogError.
  void Add(const std::string& log);

  /// The same with events that an index tells of, which are not read for it.
  void Add(const std::string& log, std::span<const IndexedEvent> events);

  /// Frames that have a part, in the order of the log.
  const std::vector<FrameId>& FramesWith(Part part) const;

  /// The parts of a frame that are there and can be decoded.
  Frame Get(const FrameId& id, const PartSet& parts);

 private:
  struct Place {
    size_t log;
    int64_t offset;
  };
  void Put(Part part, FrameId id, Place place);

  using Key = std::pair<int64_t, int64_t>;  // utime, seq

  std::string prefix_;
  std::deque<EventFetcher> fetchers_;
  std::map<Part, std::map<Key, Place>> places_;
  std::map<Part, std::vector<FrameId>> frames_;
};

}  // namespace sprout::batch

#endif  // SPROUT_SERVICES_BATCH_FRAME_LOOKUP_H_
