#include "services/view/view_session.h"

#include <algorithm>

#include "common/core/image.h"

namespace sprout::view {
namespace {

nlohmann::json RectJson(const cv::Rect& rect) { return {rect.x, rect.y, rect.width, rect.height}; }

size_t FramesFor(int64_t pixels) {
  const size_t bytes = sizeof(float) * static_cast<size_t>(pixels);
  return std::clamp<size_t>(TargetPanel::kMaxBytes / bytes, 1, TargetPanel::kMaxFrames);
}

constexpr int kMinWidth = 16;
constexpr int kMaxWidth = 4096;
constexpr double kMaxTargetDistance = 10000;  // m

// A whole number of a message; nothing for any other value.
std::optional<int64_t> NumberOf(const nlohmann::json& message, const char* name) {
  const auto found = message.find(name);
  if (found == message.end() || !found->is_number_integer()) return std::nullopt;
  return found->get<int64_t>();
}

bool FlagOf(const nlohmann::json& message, const char* name) {
  const auto found = message.find(name);
  return found != message.end() && found->is_boolean() && found->get<bool>();
}

Result<ShownParts> ShownPartsOf(const nlohmann::json& message) {
  ShownParts parts{
      .pictures = {}, .cloud = FlagOf(message, "cloud"), .seeds = FlagOf(message, "seeds")};
  const auto pictures = message.find("pictures");
  if (pictures == message.end() || !pictures->is_object() || pictures->size() > kPictureCount) {
    return Fail("wish: pictures are missing");
  }
  for (const auto& [name, width] : pictures->items()) {
    const std::optional<Picture> picture = PictureOf(name);
    if (!picture || !width.is_number_integer()) return Fail("wish: no picture is called that");
    const auto columns = std::clamp<int64_t>(width.get<int64_t>(), kMinWidth, kMaxWidth);
    parts.pictures.emplace_back(*picture, static_cast<int>(columns));
  }
  return parts;
}

// A rectangle of a message. TargetMeter checks whether it lies in the image.
Result<std::optional<cv::Rect>> RectOf(const nlohmann::json& message, const char* name) {
  const auto found = message.find(name);
  if (found == message.end()) return std::optional<cv::Rect>();
  std::vector<int> numbers;
  if (found->is_array() && found->size() == 4) {
    for (const nlohmann::json& number : *found) {
      const int64_t px = number.is_number_integer() ? number.get<int64_t>() : -1;
      if (px >= 0 && px < kMaxSide) numbers.push_back(static_cast<int>(px));
    }
  }
  if (numbers.size() != 4)
    return Fail("measure: allowed are rectangles of whole numbers of an image");
  return std::optional(cv::Rect(numbers[0], numbers[1], numbers[2], numbers[3]));
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
  // The number of frames depends on the region's size, which is known only once it is checked.
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
  if (std::string why = TargetComplaint(quality); !why.empty()) answer["error"] = std::move(why);
  return answer;
}

Result<void> ViewSession::OnMessage(std::string_view text) {
  const auto message = nlohmann::json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!message.is_object()) return Fail("a message that is no JSON object");
  const auto type_field = message.find("type");
  const std::string type = type_field != message.end() && type_field->is_string()
                               ? type_field->get<std::string>()
                               : std::string();
  if (type == "drawn") {
    drawing_ = false;
  } else if (type == "wish") {
    Result<ShownParts> parts = ShownPartsOf(message);
    if (!parts) return tl::unexpected(parts.error());
    parts_ = std::move(*parts);
    wish_changed_ = true;
  } else if (type == "live") {
    Release();
    live_ = true;
    look_.reset();
  } else if (type == "pause") {
    Keep();
  } else if (type == "look") {
    const auto key = NumberOf(message, "key");
    if (!key) return Fail("look: key is missing");
    Keep();
    look_ = *key;
  } else if (type == "probe") {
    const auto u = NumberOf(message, "u");
    const auto v = NumberOf(message, "v");
    if (!u || !v || *u < 0 || *v < 0 || *u >= kMaxSide || *v >= kMaxSide) {
      return Fail("probe: u and v: allowed are the pixels of an image");
    }
    probe_ = {static_cast<int>(*u), static_cast<int>(*v)};
  } else if (type == "measure") {
    return OnMeasure(message);
  } else {
    return Fail("a message of an unknown type");
  }
  return {};
}

Result<void> ViewSession::OnMeasure(const nlohmann::json& message) {
  panel_.reset();
  if (FlagOf(message, "off")) return {};
  TargetSettings settings;
  for (const auto& [name, rect] :
       {std::pair{"region", &settings.region}, {"edge", &settings.edge}}) {
    const auto found = RectOf(message, name);
    if (!found) return tl::unexpected(found.error());
    *rect = *found;
  }
  if (const auto distance = message.find("distance_m"); distance != message.end()) {
    const double metres = distance->is_number() ? distance->get<double>() : 0;
    if (!(metres > 0) || metres > kMaxTargetDistance) {
      return Fail("measure: distance_m: allowed is a number above 0, m");
    }
    settings.distance_m = metres;
  }
  panel_ = std::make_shared<TargetPanel>(settings);
  to_measure_ = true;
  return {};
}

StoredFramePtr ViewSession::Find(int64_t key) const {
  const auto kept = std::find_if(kept_.begin(), kept_.end(),
                                 [key](const StoredFramePtr& frame) { return frame->key == key; });
  return kept != kept_.end() ? *kept : source_.Get(key);
}

StoredFramePtr ViewSession::Wanted() {
  if (live_) return source_.Newest();
  if (!look_) return shown_;
  // While a log is still being read a frame may get more parts.
  StoredFramePtr frame = Find(*look_);
  if (!frame) gone_ = std::exchange(look_, std::nullopt);
  return frame;
}

std::optional<ViewSession::Show> ViewSession::TakeFrame() {
  if (drawing_) return std::nullopt;
  StoredFramePtr frame = Wanted();
  if (!frame) return std::nullopt;
  const bool same = shown_ && shown_->key == frame->key && shown_->version == frame->version;
  if (same && !wish_changed_) return std::nullopt;
  wish_changed_ = false;
  drawing_ = true;
  to_measure_ = true;
  shown_ = std::move(frame);
  return Show{shown_, parts_};
}

std::optional<ViewSession::Probe> ViewSession::TakeProbe() {
  if (!probe_ || !shown_) return std::nullopt;
  const auto [u, v] = *std::exchange(probe_, std::nullopt);
  return Probe{shown_, u, v};
}

std::optional<ViewSession::Measure> ViewSession::TakeMeasure() {
  if (!panel_ || !shown_ || !to_measure_) return std::nullopt;
  to_measure_ = false;
  return Measure{shown_, panel_};
}

KeyRange ViewSession::keys() const {
  return kept_.empty() ? source_.keys() : KeyRange{kept_.front()->key, kept_.back()->key};
}

void ViewSession::Keep() {
  if (!live_) return;
  live_ = false;
  std::vector<StoredFramePtr> frames = source_.Snapshot();
  // From the newest on, so that the oldest are left out when the memory does not suffice.
  for (auto frame = frames.rbegin(); frame != frames.rend(); ++frame) {
    if (!budget_.Take((*frame)->bytes())) break;
    kept_bytes_ += (*frame)->bytes();
    kept_.push_back(std::move(*frame));
  }
  std::reverse(kept_.begin(), kept_.end());
}

void ViewSession::Release() {
  budget_.Give(kept_bytes_);
  kept_bytes_ = 0;
  kept_.clear();
}

}  // namespace sprout::view
