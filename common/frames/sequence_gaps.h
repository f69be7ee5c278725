#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
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
///
/// Several captures may send on the same channels. A stream that another one seemed to replace is
/// remembered for some frames; when it goes on with its next number, each has gaps of its own. The
/// first change from one to another that has larger numbers still counts as one gap.
class SequenceGaps {
 public:
  static constexpr int kRestartFrames = 8;

  /// A frame that was not seen before, or not recently.
  /// @returns true when the stream is now known to have restarted.
  bool Add(const FrameId& id);

  int64_t count() const { return count_; }

  /// Frames whose number is above that of the frame before in their stream, and whose time is not.
  int64_t times_back() const { return times_back_; }

 private:
  struct Stream {
    FrameId newest;
    int64_t added;        // its number among all frames
    bool goes_on_beside;  // it went on after a frame of another one
  };

  // The stream of `streams_` that a frame continues.
  struct Continued {
    size_t stream;
    int64_t left_out;
  };

  // Frames in a row that do not continue the stream.
  struct Aside {
    int64_t newest_seq;
    int frames = 1;
    int64_t gaps = 0;
  };

  std::optional<Continued> Find(const FrameId& id) const;
  void Begin(const FrameId& id, bool goes_on_beside);
  bool AddAside(const FrameId& id);

  std::deque<Stream> streams_;  // the one that went on last is the last
  int64_t added_ = 0;
  std::optional<Aside> aside_;
  int64_t count_ = 0;
  int64_t times_back_ = 0;
};

}  // namespace sprout
