#ifndef SPROUT_COMMON_BUS_FRAME_JOINER_H_
#define SPROUT_COMMON_BUS_FRAME_JOINER_H_

#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "common/core/frame.h"

namespace sprout {

/// Puts the messages of one capture together again.
///
/// Parts belong together when their whole FrameId is equal. The calibration travels apart, once a
/// second: it joins every frame that names its rig_id. A frame that completes makes older
/// unfinished ones hopeless (each channel keeps its order), so they are dropped and counted. A
/// frame that is sent twice is joined twice. Not thread-safe; no I/O.
class FrameJoiner {
 public:
  static constexpr size_t kDefaultMaxPending = 16;

  /// @param needed       parts that make a frame complete; at least one that is not kRig.
  /// @param max_pending  unfinished frames kept at most; the oldest is dropped and counted.
  ///                     Must exceed the frames that enter while one passes the stages before this
  ///                     one; a whole frame of 2 MP in colour takes 8 MB.
  explicit FrameJoiner(PartSet needed, size_t max_pending = kDefaultMaxPending);

  /// Adds one part; a part that was there already is replaced.
  /// @returns the frames that are complete now, oldest first: none or one, and more only when a
  ///          late calibration completes several.
  std::vector<Frame> Add(const FrameId& id, Part part, PartValue value);

  /// Drops what is unfinished, and counts it: the stream has ended.
  void DropPending();

  /// Frames dropped because some part never came.
  int64_t incomplete() const { return incomplete_; }

  /// Frame numbers left out in the stream. A capture that starts again with smaller numbers and a
  /// later time is no gap.
  int64_t sequence_gaps() const { return sequence_gaps_; }

 private:
  struct Pending {
    Frame frame;
    PartSet present;
  };

  Pending& FindOrStart(const FrameId& id);
  void CountGap(const FrameId& id);
  void Drop(const Pending& pending);
  bool IsAccountedFor(const FrameId& id) const;
  void Account(const FrameId& id);
  std::optional<Rig> FindRig(const std::string& rig_id) const;
  bool IsComplete(const Pending& pending) const;
  std::vector<Frame> TakeComplete();

  PartSet needed_;
  size_t max_pending_;
  std::deque<Pending> pending_;                   // in order of arrival
  std::deque<FrameId> accounted_;                 // completed or dropped, the newest few
  std::deque<std::pair<std::string, Rig>> rigs_;  // by rig_id, the newest few
  std::optional<FrameId> newest_;
  int64_t incomplete_ = 0;
  int64_t sequence_gaps_ = 0;
};

}  // namespace sprout

#endif  // SPROUT_COMMON_BUS_FRAME_JOINER_H_
