#ifndef SPROUT_SERVICES_VIEW_STORED_FRAME_H_
#define SPROUT_SERVICES_VIEW_STORED_FRAME_H_

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "common/core/frame.h"

namespace sprout::view {

/// A received message; shared, never changed.
using StoredBytes = std::shared_ptr<const std::vector<uint8_t>>;

/// The messages of one capture, still encoded: a decoded frame takes several times the memory, and
/// most frames are never shown. Immutable: a frame that gets another part becomes a new object with
/// the same key.
struct StoredFrame {
  int64_t key = 0;      ///< +1 for each capture, in the order in which they were first heard
  int64_t version = 0;  ///< +1 for each part that is shown
  FrameId id;
  std::array<StoredBytes, kPartCount> parts;  ///< by number of the part; null: not here

  const StoredBytes& part(Part which) const { return parts[static_cast<size_t>(which)]; }
  bool Has(Part which) const { return part(which) != nullptr; }

  /// Memory of its messages. O(parts).
  size_t bytes() const {
    size_t sum = 0;
    for (const StoredBytes& message : parts) sum += message ? message->size() : 0;
    return sum;
  }
};

using StoredFramePtr = std::shared_ptr<const StoredFrame>;

}  // namespace sprout::view

#endif  // SPROUT_SERVICES_VIEW_STORED_FRAME_H_
