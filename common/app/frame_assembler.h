#pragma once

#include <cstdint>
#include <deque>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/app/stage_monitor.h"
#include "common/core/frame.h"
#include "common/frames/frame_joiner.h"

namespace sprout {

/// Messages in, complete frames out: decodes and checks messages, joins them, and counts what is
/// dropped. A frame may come twice, with the same bytes; of two messages of one frame and channel
/// that differ the first counts, and the other is a bad one. Warns of calibrations that change
/// under one rig_id, and, where it joins the ToF image, as the first stage alone does, of times
/// that do not rise, twice in 100 frames; those of a recording that plays again are known. Not
/// thread-safe.
class FrameAssembler {
 public:
  /// @param max_pending, optional  as in FrameJoiner.
  FrameAssembler(PartSet needed, StageMonitor& monitor,
                 size_t max_pending = FrameJoiner::kDefaultMaxPending, PartSet optional = {});

  /// Channels that carry the needed parts, without prefix.
  const std::vector<std::string_view>& channels() const { return channels_; }

  /// Takes one message. Never throws: messages that cannot be used are counted in the monitor.
  /// @param memory  as in DecodePart().
  /// @returns the frames that are complete now.
  std::vector<Frame> Add(std::string_view channel, std::span<const uint8_t> bytes,
                         const cv::Mat1b& memory = {});

  /// The end of the messages: unfinished frames are counted as incomplete.
  /// @returns those that lack optional parts alone.
  std::vector<Frame> Finish();

 private:
  static constexpr size_t kFramesTold = 100;  // that times do not rise

  struct Taken {
    FrameId id;
    Part part;
    uint64_t hash;
  };

  bool IsSecondAnswer(const Taken& message) const;
  void TellOtherRig(const FrameId& id);
  bool IsKnownTime(int64_t utime);
  void TellTimesBack(const FrameId& id, size_t whole_frames);

  StageMonitor& monitor_;
  PartSet needed_;
  std::vector<std::string_view> channels_;
  FrameJoiner joiner_;
  std::deque<Taken> taken_;    // the newest messages
  int64_t rigs_replaced_ = 0;  // that were told
  int64_t times_back_ = 0;
  std::deque<int64_t> utimes_;  // of the newest frames
  size_t frames_since_back_ = kFramesTold;
  std::string time_warning_;  // that holds now
};

}  // namespace sprout
