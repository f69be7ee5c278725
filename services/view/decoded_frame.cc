#include "services/view/decoded_frame.h"

#include <exception>
#include <utility>

#include "common/messages/codec.h"

namespace sprout::view {

const PartValue* DecodedFrame::Decode(Part part) {
  const std::lock_guard lock(mutex_);
  const auto i = static_cast<size_t>(part);
  if (!tried_[i] && stored_->parts[i]) {
    tried_[i] = true;
    try {
      const auto expected = part == Part::kRig ? std::nullopt : CalibratedSize();
      Result<DecodedPart> decoded = DecodePart(part, *stored_->parts[i], expected);
      if (decoded) {
        values_[i] = std::move(decoded->value);
      } else {
        complain_(part, decoded.error().text);
      }
    } catch (const std::exception& e) {  // out of memory
      complain_(part, e.what());
    }
  }
  return values_[i] ? &*values_[i] : nullptr;
}

std::optional<cv::Size> DecodedFrame::CalibratedSize() {
  const Rig* rig = Get<Rig>(Part::kRig);
  return rig == nullptr ? std::nullopt : std::optional(rig->pair.size());
}

std::optional<cv::Size> DecodedFrame::size() {
  if (const auto calibrated = CalibratedSize()) return calibrated;
  if (const auto* left = Get<cv::Mat>(Part::kLeft)) return left->size();
  if (const auto* map = Get<DisparityImage>(Part::kDisparity)) return map->size();
  return std::nullopt;
}

Frame DecodedFrame::ToFrame() {
  Frame frame;
  frame.id = stored_->id;
  for (const Part part : kAllParts) {
    if (const PartValue* value = Decode(part)) SetPart(frame, part, *value);
  }
  return frame;
}

}  // namespace sprout::view
