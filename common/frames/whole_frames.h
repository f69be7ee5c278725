#ifndef SPROUT_COMMON_FRAMES_WHOLE_FRAMES_H_
#define SPROUT_COMMON_FRAMES_WHOLE_FRAMES_H_

#include <cstdint>
#include <deque>
#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "common/frames/frame_index.h"
#include "common/frames/frame_joiner.h"
#include "common/logfile/channel_counts.h"
#include "common/logfile/log_reader.h"

namespace sprout {

/// A frame of a log that has all that is needed, and where it has it from.
struct WholeFrame {
  Frame frame;
  IndexedFrame places;
};

/// The whole frames of a log one after the other, as a stage that listens would get them: the rule
/// is that of FrameJoiner, with its counts and its bounded memory. Calibrations are always looked
/// at, and the size of a frame's images as FrameJoiner::AddMessage() does.
class WholeFrames {
 public:
  /// @param prefix  before the channels of the graph.
  /// @param refuse  is told of each message that is refused at the border.
  /// @throws LogError when the file cannot be opened or is no log.
  WholeFrames(const std::filesystem::path& path, std::string prefix, PartSet needed, Refuse refuse);

  /// Takes a calibration beforehand, which holds from the start of the log. @pre it can be decoded.
  void AddRig(std::span<const uint8_t> message);

  /// Nothing at the end; what is unfinished then is counted.
  std::optional<WholeFrame> Next();

  const FrameJoiner& joiner() const { return joiner_; }              ///< its counts
  const ChannelCounts& channels() const { return channels_; }        ///< met so far
  const LogReader& log() const { return reader_; }                   ///< its damage
  std::optional<int64_t> newest_rig() const { return newest_rig_; }  ///< offset; read so far

 private:
  void Take(const LogEvent& event);
  IndexedFrame& PlacesOf(const FrameId& id);

  std::string prefix_;
  PartSet needed_;
  Refuse refuse_;
  LogReader reader_;
  FrameJoiner joiner_;
  ChannelCounts channels_;
  std::optional<int64_t> newest_rig_;
  std::deque<IndexedFrame> pending_;  // as in the joiner
  std::deque<WholeFrame> ready_;
};

}  // namespace sprout

#endif  // SPROUT_COMMON_FRAMES_WHOLE_FRAMES_H_
