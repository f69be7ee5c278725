#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "common/core/frame.h"
#include "common/core/result.h"

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

/// A stored frame whose parts are decoded on demand, each once. Thread-safe.
class DecodedFrame {
 public:
  /// Called once for each part that cannot be decoded.
  using Complain = std::function<void(Part part, const std::string& why)>;

  DecodedFrame(StoredFramePtr stored, Complain complain)
      : stored_(std::move(stored)), complain_(std::move(complain)) {}

  const StoredFrame& stored() const { return *stored_; }

  /// The value of a part, T as in PartValue; null when it is missing or cannot be decoded. Valid
  /// for the life of this object.
  template <typename T>
  const T* Get(Part part) {
    const PartValue* value = Decode(part);
    return value == nullptr ? nullptr : std::get_if<T>(value);
  }

  /// Size of the rectified images of this frame: from the calibration, or else the left image or
  /// the disparity map; nothing without these.
  std::optional<cv::Size> size();

  /// The frame with all its parts.
  Frame ToFrame();

 private:
  const PartValue* Decode(Part part);
  std::optional<cv::Size> CalibratedSize();

  StoredFramePtr stored_;
  Complain complain_;
  std::recursive_mutex mutex_;
  std::array<std::optional<PartValue>, kPartCount> values_;
  std::array<bool, kPartCount> tried_{};
};

}  // namespace sprout::view
