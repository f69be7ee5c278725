#ifndef SPROUT_COMMON_FRAMES_LOG_FRAMES_H_
#define SPROUT_COMMON_FRAMES_LOG_FRAMES_H_

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "common/frames/frame_index.h"
#include "common/logfile/event_fetcher.h"
#include "common/logfile/log_reader.h"

namespace sprout {

/// A part and what it holds.
using ReadPart = std::pair<Part, PartValue>;

/// Reads those of `parts` that are there from the log of a frame. What cannot be decoded is told
/// and left out. @throws LogError when the log was changed meanwhile.
std::vector<ReadPart> FetchParts(EventFetcher& log, const IndexedFrame& places,
                                 const PartSet& parts, const Refuse& refuse = {});

/// The frames of a log one after the other, each with what the log holds of it, whole or not; what
/// a frame is, see FrameIndex. Each is read when it is over, so memory is that of one frame and of
/// the index.
class LogFrames {
 public:
  /// Called with how many bytes of the log are read, at each event.
  using Progress = std::function<void(int64_t position)>;

  /// @throws LogError when the file cannot be opened or is no log.
  LogFrames(const std::filesystem::path& path, FrameChoice choice, Refuse refuse = {});

  /// The next frame of which at least one part could be read, in the order of their first messages,
  /// and with its calibration when that is wanted and stands anywhere in the log; nothing at the
  /// end. @throws LogError when reading fails.
  std::optional<Frame> Next(const Progress& progress = {});

  const LogReader& log() const { return reader_; }
  const FrameIndex& index() const { return index_; }

 private:
  IndexedFrame PlacesOf(size_t number);

  std::filesystem::path path_;
  FrameChoice choice_;
  Refuse refuse_;
  LogReader reader_;
  EventFetcher fetcher_;
  FrameIndex index_;
  size_t next_ = 0;              // number of the frame that is given next
  bool knows_all_rigs_ = false;  // also those that stand further on
};

}  // namespace sprout

#endif  // SPROUT_COMMON_FRAMES_LOG_FRAMES_H_
