#ifndef SPROUT_COMMON_FRAMES_FRAME_JOINER_H_
#define SPROUT_COMMON_FRAMES_FRAME_JOINER_H_

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

/// Puts the messages of one capture together again: the rule of all who need whole frames, live and
/// from logs (stages, replays, capture's log feed, calibrate). Who looks into a log for what is
/// there, whole or not, has that of FrameIndex.
///
/// Parts belong together when their whole FrameId is equal. The calibration travels apart, once a
/// second: it joins every frame that names its rig_id. A frame that completes makes older
/// unfinished ones hopeless (each channel keeps its order), so they are dropped and counted. A
/// frame that is sent twice is joined twice. Not thread-safe; no I/O.
class FrameJoiner {
 public:
  static constexpr size_t kDefaultMaxPending = 16;

  /// 64 frames of 2 MP with all their parts; one of 100 MP.
  static constexpr size_t kDefaultMaxBytes = size_t{1} << 30;

  /// @param needed       parts that make a frame complete; at least one that is not kRig.
  /// @param max_pending  unfinished frames kept at most; the oldest is dropped and counted.
  ///                     Must exceed the frames that enter while one passes the stages before this
  ///                     one; a whole frame of 2 MP in colour takes 8 MB.
  /// @param max_bytes    memory that unfinished frames may keep; beyond it the oldest is dropped
  ///                     and counted.
  explicit FrameJoiner(PartSet needed, size_t max_pending = kDefaultMaxPending,
                       size_t max_bytes = kDefaultMaxBytes);

  /// Adds one part; a part that was there already is replaced.
  /// @returns the frames that are complete now, oldest first: none or one, and more only when a
  ///          late calibration completes several.
  std::vector<Frame> Add(const FrameId& id, Part part, PartValue value);

  /// Decodes the message of a part, of which a compressed picture or map must have the size that is
  /// known of its frame (ImageSizeOf()), and adds it.
  /// @returns as Add(); an error for a message that is refused at the border, see DecodePart().
  Result<std::vector<Frame>> AddMessage(Part part, std::span<const uint8_t> bytes);

  /// Size that the rectified images of a frame have: as its calibration says, or else as its first
  /// image or map does; nothing when neither is here yet.
  std::optional<cv::Size> ImageSizeOf(const FrameId& id) const;

  /// Whether parts of an unfinished frame of this name are here.
  bool IsPending(const FrameId& id) const;

  /// Drops what is unfinished, and counts it: the stream has ended.
  void DropPending();

  /// Frames dropped because some part never came.
  int64_t incomplete() const { return incomplete_; }

  /// Frame numbers left out in the stream.
  int64_t sequence_gaps() const { return gaps_.count(); }

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
  bool IsComplete(const Pending& pending) const;
  std::vector<Frame> TakeComplete();

  PartSet needed_;
  size_t max_pending_;
  size_t max_bytes_;
  std::deque<Pending> pending_;                   // in order of arrival
  std::deque<FrameId> accounted_;                 // completed or dropped, the newest few
  std::deque<std::pair<std::string, Rig>> rigs_;  // by rig_id, the newest few
  SequenceGaps gaps_;
  int64_t incomplete_ = 0;
};

}  // namespace sprout

#endif  // SPROUT_COMMON_FRAMES_FRAME_JOINER_H_
