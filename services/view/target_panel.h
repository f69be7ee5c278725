#ifndef SPROUT_SERVICES_VIEW_TARGET_PANEL_H_
#define SPROUT_SERVICES_VIEW_TARGET_PANEL_H_

#include <cstddef>
#include <deque>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "common/measure/target_meter.h"
#include "services/view/decoded_frame.h"

namespace sprout::view {

/// Measures a flat target in the frames that a page is shown, as sprout-quality does. All frames
/// have the calibration of the first one; with another it begins anew. For one thread.
class TargetPanel {
 public:
  /// What the depths of one page may take: the more pixels, the fewer frames.
  static constexpr size_t kMaxBytes = size_t{64} << 20;
  static constexpr size_t kMaxFrames = 40;

  /// @param settings  `count` is not looked at.
  explicit TargetPanel(TargetSettings settings) : settings_(std::move(settings)) {}

  /// What there is to tell with this frame, which is added unless it was before: {region: [left,
  /// top, width, height], edge, frames, figures: [{name, title, text, meaning}]} or {error: why}.
  /// O(pixels of the region · frames).
  nlohmann::json Show(DecodedFrame& frame);

 private:
  Result<void> Begin(const Rig& rig, cv::Size size);
  nlohmann::json Figures() const;

  TargetSettings settings_;
  std::optional<TargetMeter> meter_;
  std::string rig_id_;
  std::deque<int64_t> keys_;  // of the frames in the meter
};

}  // namespace sprout::view

#endif  // SPROUT_SERVICES_VIEW_TARGET_PANEL_H_
