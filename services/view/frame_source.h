#pragma once

#include <cstdint>
#include <vector>

#include "services/view/decoded_frame.h"

namespace sprout::view {

/// Keys of the available frames.
struct KeyRange {
  int64_t first = 0;
  int64_t last = -1;  ///< < first: none

  bool operator==(const KeyRange&) const = default;
};

/// A source of frames: the running graph, or a log. Thread-safe.
class FrameSource {
 public:
  FrameSource() = default;
  virtual ~FrameSource() = default;
  FrameSource(const FrameSource&) = delete;
  FrameSource& operator=(const FrameSource&) = delete;

  /// The newest frame to show; null: none yet.
  virtual StoredFramePtr Newest() const = 0;

  /// A frame by its key; null when it does not exist, or no longer.
  virtual StoredFramePtr Get(int64_t key) const = 0;

  virtual KeyRange keys() const = 0;

  /// All frames that Get() gives now, to be kept by a paused page, since frames of the running
  /// graph vanish. Empty for a log, whose frames stay.
  virtual std::vector<StoredFramePtr> Snapshot() const = 0;
};

}  // namespace sprout::view
