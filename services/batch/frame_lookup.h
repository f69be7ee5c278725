#ifndef SPROUT_SERVICES_BATCH_FRAME_LOOKUP_H_
#define SPROUT_SERVICES_BATCH_FRAME_LOOKUP_H_

#include <deque>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/core/frame.h"
#include "common/frames/frame_index.h"
#include "common/logfile/event_fetcher.h"
#include "services/batch/log_index.h"

namespace sprout::batch {

/// Finds the parts of frames in small logs, in any order; the parts of one frame may be in several
/// logs. Opening a log reads the positions of its messages.
class FrameLookup {
 public:
  explicit FrameLookup(std::string prefix) : prefix_(std::move(prefix)) {}

  /// Adds the parts of a log that a stage wrote, which is undamaged. @throws LogError.
  void Add(const std::string& log);

  /// The same with events known from an index, without reading them.
  void Add(const std::string& log, std::span<const IndexedEvent> events);

  /// Frames that have a part, in the order of the logs.
  std::vector<FrameId> FramesWith(Part part) const;

  /// The parts of a frame that exist and can be decoded; if several logs have a part, it is taken
  /// from the last. An empty rig_id matches any.
  Frame Get(const FrameId& id, const PartSet& parts);

 private:
  struct Log {
    Log(const std::string& path, const FrameChoice& choice) : fetcher(path), index(choice) {}

    EventFetcher fetcher;
    FrameIndex index;
  };
  Log& Open(const std::string& log);

  std::string prefix_;
  std::deque<Log> logs_;
};

}  // namespace sprout::batch

#endif  // SPROUT_SERVICES_BATCH_FRAME_LOOKUP_H_
