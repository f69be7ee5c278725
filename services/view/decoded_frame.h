#ifndef SPROUT_SERVICES_VIEW_DECODED_FRAME_H_
#define SPROUT_SERVICES_VIEW_DECODED_FRAME_H_

#include <array>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <variant>

#include "common/core/frame.h"
#include "common/core/result.h"
#include "services/view/stored_frame.h"

namespace sprout::view {

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

#endif  // SPROUT_SERVICES_VIEW_DECODED_FRAME_H_
