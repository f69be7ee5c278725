#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/core/frame.h"
#include "common/core/result.h"
#include "common/frames/sequence_gaps.h"

namespace sprout {

/// Joins the messages of one capture to a frame: the rule of all programs that need complete
/// frames, live and from logs (stages, replays, capture's log feed, calibrate). Programs that
/// inspect logs, complete frames or not, use FrameIndex.
///
/// Parts belong together when their FrameIds are equal. The calibration comes separately, once a
/// second: it joins every frame with its rig_id. When a frame is complete, older unfinished ones
/// cannot be completed any more (each channel keeps its order), so they are dropped and counted. A
/// frame that is sent twice is joined twice. Not thread-safe; no I/O.
class FrameJoiner {
 public:
  static constexpr size_t kDefaultMaxPending = 16;

  /// 64 frames of 2 MP with all their parts; one of 100 MP.
  static constexpr size_t kDefaultMaxBytes = size_t{1} << 30;

  /// @param needed       parts that make a frame complete; at least one that is not kRig.
  /// @param max_pending  unfinished frames kept at most; the oldest is dropped and counted.
  ///                     Must exceed the number of frames that arrive while one passes the earlier
  ///                     stages; a complete frame of 2 MP in colour takes 8 MB.
  /// @param max_bytes    memory that unfinished frames may keep; beyond it the oldest is dropped
  ///                     and counted.
  /// @param optional     of `needed`: a frame without these is complete, too, once a later one has
  ///                     all others.
  explicit FrameJoiner(PartSet needed, size_t max_pending = kDefaultMaxPending,
                       size_t max_bytes = kDefaultMaxBytes, PartSet optional = {});

  /// Adds one part; replaces an earlier one.
  /// @returns the frames that are complete now, oldest first: none or one, and more only when a
  ///          late calibration completes several.
  std::vector<Frame> Add(const FrameId& id, Part part, PartValue value);

  /// Decodes the message of a part and adds it. A compressed picture or map must have the size
  /// known for its frame (ImageSizeOf()).
  /// @param memory  as in DecodePart().
  /// @returns as Add(); an error for a message that is refused, see DecodePart().
  Result<std::vector<Frame>> AddMessage(Part part, std::span<const uint8_t> bytes,
                                        const cv::Mat1b& memory = {});

  /// Size of the rectified images of a frame: from its calibration, or else from its first image or
  /// map; nothing when neither has come yet.
  std::optional<cv::Size> ImageSizeOf(const FrameId& id) const;

  /// Whether parts of an unfinished frame with this id are waiting.
  bool IsPending(const FrameId& id) const;

  /// The end of the stream: drops and counts unfinished frames.
  /// @returns those that lack optional parts alone.
  std::vector<Frame> DropPending();

  /// Frames dropped because a part was missing.
  int64_t incomplete() const { return incomplete_; }

  /// Frame numbers missing in the stream.
  int64_t sequence_gaps() const { return gaps_.count(); }

  /// Frames whose number rose and whose time did not.
  int64_t times_back() const { return gaps_.times_back(); }

  /// Calibrations that replaced one with other numbers and the same rig_id.
  int64_t rigs_replaced() const { return rigs_replaced_; }

 private:
  struct Pending {
    Frame frame;
    PartSet present;
  };

  size_t IndexOf(const FrameId& id) const;
  Pending& FindOrStart(const FrameId& id);
  void DropOldest();
  void KeepWithinBudget();
  void Drop(const Pending& pending);
  bool IsAccountedFor(const FrameId& id) const;
  void Account(const FrameId& id);
  std::optional<Rig> FindRig(const std::string& rig_id) const;
  bool Has(const Pending& pending, Part part) const;
  bool IsComplete(const Pending& pending) const;
  bool LacksOptionalOnly(const Pending& pending) const;
  size_t CountReady() const;
  std::vector<Frame> TakeFirst(size_t count);

  PartSet needed_;
  PartSet optional_;
  size_t max_pending_;
  size_t max_bytes_;
  std::deque<Pending> pending_;                   // in order of arrival
  std::deque<FrameId> accounted_;                 // completed or dropped, the newest few
  std::deque<std::pair<std::string, Rig>> rigs_;  // by rig_id, the newest few
  SequenceGaps gaps_;
  int64_t incomplete_ = 0;
  int64_t rigs_replaced_ = 0;
};

}  // namespace sprout
