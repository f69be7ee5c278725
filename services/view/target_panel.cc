#include "services/view/target_panel.h"

#include <algorithm>

namespace sprout::view {
namespace {

nlohmann::json RectJson(const cv::Rect& rect) { return {rect.x, rect.y, rect.width, rect.height}; }

size_t FramesFor(int64_t pixels) {
  const size_t bytes = sizeof(float) * static_cast<size_t>(pixels);
  return std::clamp<size_t>(TargetPanel::kMaxBytes / bytes, 1, TargetPanel::kMaxFrames);
}

}  // namespace

nlohmann::json TargetPanel::Show(DecodedFrame& frame) {
  const auto* const map = frame.Get<DisparityImage>(Part::kDisparity);
  const auto* const rig = frame.Get<Rig>(Part::kRig);
  if (map == nullptr || map->empty()) return {{"error", "this frame has no disparity map"}};
  if (rig == nullptr) return {{"error", "the calibration of this frame is not known"}};
  if (const Result<void> begun = Begin(*rig, map->size()); !begun) {
    return {{"error", begun.error().text}};
  }
  const int64_t key = frame.stored().key;
  if (std::ranges::find(keys_, key) == keys_.end()) {
    const auto* const sigma = frame.Get<cv::Mat>(Part::kSigma);
    const bool fits = sigma != nullptr && sigma->type() == CV_8UC1 && sigma->size() == map->size();
    meter_->Add(ToPx(*map), fits ? cv::Mat1b(*sigma) : cv::Mat1b());
    keys_.push_back(key);
    while (keys_.size() > meter_->frames()) keys_.pop_front();
  }
  return Figures();
}

Result<void> TargetPanel::Begin(const Rig& rig, cv::Size size) {
  const std::string rig_id = RigId(rig);
  if (meter_ && rig_id == rig_id_ && size == rig.pair.size()) return {};
  meter_.reset();
  keys_.clear();
  // The region is known only once it is checked.
  settings_.count = kMaxFrames;
  Result<TargetMeter> meter = TargetMeter::For(settings_, rig.pair, size);
  if (!meter) return tl::unexpected(meter.error());
  settings_.count = FramesFor(meter->region().area());
  meter_ = *TargetMeter::For(settings_, rig.pair, size);
  rig_id_ = rig_id;
  return {};
}

nlohmann::json TargetPanel::Figures() const {
  const TargetQuality quality = meter_->Quality();
  nlohmann::json figures = nlohmann::json::array();
  for (const TargetFigure& figure : TargetFigures()) {
    if (!(quality.*figure.value)) continue;
    figures.push_back({{"name", figure.name},
                       {"title", figure.title},
                       {"text", TargetText(figure, quality)},
                       {"meaning", figure.meaning}});
  }
  nlohmann::json answer{{"region", RectJson(meter_->region())},
                        {"frames", quality.frames},
                        {"figures", std::move(figures)}};
  if (meter_->edge()) answer["edge"] = RectJson(*meter_->edge());
  if (!quality.distance_m) answer["error"] = "no plane: too few pixels have a disparity";
  return answer;
}

}  // namespace sprout::view
