#ifndef SPROUT_COMMON_FRAMES_SEQUENCE_GAPS_H_
#define SPROUT_COMMON_FRAMES_SEQUENCE_GAPS_H_

#include <cstdint>
#include <optional>

#include "common/core/frame_id.h"

namespace sprout {

/// Counts the frame numbers that are missing in a stream of frames.
///
/// Frames that do not continue the stream are either sent again (capture's --lockstep), or the
/// stream has restarted: with a later time if capture was started again; with an older one if its
/// clock was set back, or a recording plays again from its start (--loop). A later time shows the
/// restart at once. With an older time a single frame proves nothing, but kRestartFrames
/// consecutive ones do, and then gaps between them count. So one stray message changes little, and
/// a restart of fewer frames goes unnoticed.
class SequenceGaps {
 public:
  static constexpr int kRestartFrames = 8;

  /// A frame that was not seen before, or not recently.
  /// @returns true when the stream is now known to have restarted.
  bool Add(const FrameId& id);

  int64_t count() const { return count_; }

 private:
  // Frames in a row that do not continue the stream.
  struct Aside {
    int64_t newest_seq;
    int frames = 1;
    int64_t gaps = 0;
  };

  bool AddAside(const FrameId& id);

  std::optional<FrameId> newest_;
  std::optional<Aside> aside_;
  int64_t count_ = 0;
};

}  // namespace sprout

#endif  // SPROUT_COMMON_FRAMES_SEQUENCE_GAPS_H_
