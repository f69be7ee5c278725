#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/frames/frame_index.h"
#include "common/frames/frame_joiner.h"
#include "common/logfile/channel_counts.h"
#include "common/logfile/log_reader.h"

namespace sprout {

/// A part and its content.
using ReadPart = std::pair<Part, PartValue>;

/// Reads those of `parts` that exist from the log of a frame. Undecodable ones are reported and
/// left out. @throws LogError when the log was changed meanwhile.
std::vector<ReadPart> FetchParts(EventFetcher& log, const IndexedFrame& places,
                                 const PartSet& parts, const Refuse& refuse = {});

/// The frames of a log one after the other, complete or not; see FrameIndex for what is a frame.
/// Each is read when it is over, so memory is that of one frame and of the index.
class LogFrames {
 public:
  /// Called at each event with the number of bytes read so far.
  using Progress = std::function<void(int64_t position)>;

  /// @throws LogError when the file cannot be opened or is no log.
  LogFrames(const std::filesystem::path& path, FrameChoice choice, Refuse refuse = {});

  /// The next frame of which at least one part could be read, in the order of their first messages;
  /// with its calibration if wanted and anywhere in the log. Nothing at the end. @throws LogError
  /// when reading fails, and when a wanted part of one frame comes twice with different bytes:
  /// which of them was meant is not known, as in a recording merged with a replay of its own stage.
  std::optional<Frame> Next(const Progress& progress = {});

  const LogReader& log() const { return reader_; }
  const FrameIndex& index() const { return index_; }

 private:
  IndexedFrame PlacesOf(size_t number);
  void RequireOneAnswer();

  std::filesystem::path path_;
  FrameChoice choice_;
  Refuse refuse_;
  LogReader reader_;
  EventFetcher fetcher_;
  FrameIndex index_;
  size_t checked_repeats_ = 0;
  size_t next_ = 0;              // number of the frame that is given next
  bool knows_all_rigs_ = false;  // also those further on in the log
};

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
