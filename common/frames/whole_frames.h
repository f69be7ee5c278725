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

/// A complete frame of a log, and the positions of its messages.
struct WholeFrame {
  Frame frame;
  IndexedFrame places;
};

/// The complete frames of a log one after the other, as a live stage would get them: by the rule of
/// FrameJoiner, with its counts and its bounded memory. Calibrations are always read, and sizes of
/// images are checked as by FrameJoiner::AddMessage().
class WholeFrames {
 public:
  /// @param prefix  before the channels of the graph.
  /// @param refuse  called with each message that is refused.
  /// @throws LogError when the file cannot be opened or is no log.
  WholeFrames(const std::filesystem::path& path, std::string prefix, PartSet needed, Refuse refuse);

  /// Takes a calibration in advance, which holds from the start of the log. @pre it can be decoded.
  void AddRig(std::span<const uint8_t> message);

  /// Nothing at the end; then unfinished frames are counted.
  std::optional<WholeFrame> Next();

  const FrameJoiner& joiner() const { return joiner_; }              ///< its counts
  const ChannelCounts& channels() const { return channels_; }        ///< read so far
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
