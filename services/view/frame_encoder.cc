#include "services/view/frame_encoder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "common/messages/jpeg.h"
#include "services/view/points.h"

namespace sprout::view {
namespace {

// Frames that are kept decoded: one for pages that follow the graph, others for paused pages.
constexpr size_t kMaxDecoded = 3;
constexpr size_t kMaxCacheBytes = size_t{64} << 20;

// Standard deviations of a prior, px: the same scale for all frames.
constexpr ValueRange kSigmaRange{0, 4};

constexpr std::array<std::string_view, kPictureCount> kPictureNames = {
    "left",  "tof",        "disparity",       "depth", "prior",
    "sigma", "confidence", "disparity_sigma", "fused", "fused_depth"};

nlohmann::json ScaleJson(const ValueRange& range, const char* unit, const char* near) {
  return {{"min", range.min}, {"max", range.max}, {"unit", unit}, {"near", near}};
}

cv::Mat Shrink(const cv::Mat& image, int width) {
  if (image.cols <= width) return image;
  const int height = std::max(1, cvRound(static_cast<double>(image.rows) * width / image.cols));
  cv::Mat small;
  // Averages over areas only where pixels would be left out otherwise.
  cv::resize(image, small, {width, height}, 0, 0,
             image.cols >= 2 * width ? cv::INTER_AREA : cv::INTER_LINEAR);
  return small;
}

// @param sigma_of  of the map's size.
cv::Mat3b PaintSigma(const DisparityImage& map, const cv::Mat1b& sigma_of, int width) {
  cv::Mat3b colors(256, 1);
  for (int i = 0; i < colors.rows; ++i) {
    colors(i) = ColorOf(SigmaToPx(static_cast<uint8_t>(i)), kSigmaRange);
  }
  cv::Mat3b picture;
  cv::applyColorMap(Thin(sigma_of, width), picture, colors);
  picture.setTo(kNoValueColor, Thin(map.counts(), width) == DisparityImage::kInvalid);
  return picture;
}

// The map that a picture of disparities or depths is of.
Part SourceOf(Picture picture) {
  return picture == Picture::kFused || picture == Picture::kFusedDepth ? Part::kFused
                                                                       : Part::kDisparity;
}

// The disparity map, or the prior where that has no valid pixel.
const DisparityImage* MapOf(DecodedFrame& frame) {
  const auto* map = frame.Get<DisparityImage>(Part::kDisparity);
  if (map != nullptr && !map->empty()) return map;
  const auto* prior = frame.Get<PriorMap>(Part::kPrior);
  return prior == nullptr || prior->empty() ? nullptr : &prior->disparity;
}

// The depths of a range of disparities, so that a surface has one colour in all pictures; nothing
// when the range reaches to infinity.
std::optional<ValueRange> FiniteDepths(const RectifiedPair& pair, const ValueRange& range_px) {
  const std::optional<ValueRange> in_front = InFront(pair, range_px);
  if (!in_front) return std::nullopt;
  const ValueRange range_m = DepthRange(pair, *in_front);
  return std::isfinite(range_m.max) ? std::optional(range_m) : std::nullopt;
}

}  // namespace

std::string_view NameOf(Picture picture) { return kPictureNames[static_cast<size_t>(picture)]; }

std::optional<Picture> PictureOf(std::string_view name) {
  const auto found = std::find(kPictureNames.begin(), kPictureNames.end(), name);
  if (found == kPictureNames.end()) return std::nullopt;
  return static_cast<Picture>(found - kPictureNames.begin());
}

std::shared_ptr<DecodedFrame> FrameEncoder::Decode(const StoredFramePtr& frame) {
  const std::lock_guard lock(mutex_);
  const auto found = std::find_if(decoded_.begin(), decoded_.end(), [&](const auto& decoded) {
    return decoded->stored().key == frame->key && decoded->stored().version == frame->version;
  });
  if (found != decoded_.end()) return *found;
  if (decoded_.size() == kMaxDecoded) decoded_.pop_front();
  decoded_.push_back(std::make_shared<DecodedFrame>(frame, complain_));
  return decoded_.back();
}

template <typename Make>
EncodedPartPtr FrameEncoder::Cached(const StoredFrame& frame, const std::string& what,
                                    const Make& make) {
  const auto found = std::find_if(cache_.begin(), cache_.end(), [&](const CachedPart& entry) {
    return entry.key == frame.key && entry.version == frame.version && entry.what == what;
  });
  if (found != cache_.end()) return found->part;
  EncodedPartPtr part = make();
  if (!part) return nullptr;
  cache_bytes_ += part->memory();
  cache_.push_back({frame.key, frame.version, what, part});
  while (cache_bytes_ > kMaxCacheBytes) {
    cache_bytes_ -= cache_.front().part->memory();
    cache_.pop_front();
  }
  return part;
}

void FrameEncoder::FollowRanges(DecodedFrame& frame) {
  const DisparityImage* map = MapOf(frame);
  const auto* rig = frame.Get<Rig>(Part::kRig);
  const auto* tof = frame.Get<TofImage>(Part::kTof);
  if (map != nullptr) disparity_px_ = calm_disparity_.Follow(DisparityRangeOf(*map));
  if (map != nullptr && rig != nullptr) {
    const std::optional<ValueRange> depths_m = FiniteDepths(rig->pair, disparity_px_);
    depth_m_ = depths_m ? *depths_m : calm_depth_.Follow(DepthRangeOf(*map, rig->pair));
  } else if (tof != nullptr && !tof->depth_m.empty()) {
    depth_m_ = calm_depth_.Follow(DepthRange(*tof));
  }
}

// A picture that is made smaller, and the text and scale that go with it.
struct FrameEncoder::Drawing {
  cv::Mat image;
  cv::Size full;
  JpegColors colors = JpegColors::kFull;

  static std::optional<Drawing> OfPhotograph(const cv::Mat* image, int width) {
    if (image == nullptr) return {};
    return Drawing{Shrink(*image, width), image->size(), JpegColors::kHalf};
  }
  static std::optional<Drawing> OfCounts(const DisparityImage* map, const CountColors& colors,
                                         int width) {
    if (map == nullptr || map->empty()) return {};
    return Drawing{colors.Paint(Thin(map->counts(), width)), map->size()};
  }
  static std::optional<Drawing> OfSigma(const DisparityImage* map, const cv::Mat* sigma,
                                        int width) {
    if (map == nullptr || sigma == nullptr || map->empty()) return {};
    if (sigma->type() != CV_8UC1 || sigma->size() != map->size()) return {};
    return Drawing{PaintSigma(*map, *sigma, width), map->size()};
  }
};

std::optional<FrameEncoder::Drawing> FrameEncoder::Draw(DecodedFrame& frame, Picture picture,
                                                        int width) const {
  const auto* prior = frame.Get<PriorMap>(Part::kPrior);
  switch (picture) {
    case Picture::kLeft:
      return Drawing::OfPhotograph(frame.Get<cv::Mat>(Part::kLeft), width);
    case Picture::kConfidence:
      return Drawing::OfPhotograph(frame.Get<cv::Mat>(Part::kConfidence), width);
    case Picture::kTof: {
      const auto* tof = frame.Get<TofImage>(Part::kTof);
      if (tof == nullptr || tof->depth_m.empty()) return {};
      return Drawing{ColorizeDepth(ReturnsOnly(Thin(tof->depth_m, width)), depth_m_),
                     tof->depth_m.size()};
    }
    case Picture::kDisparity:
    case Picture::kFused:
      return Drawing::OfCounts(frame.Get<DisparityImage>(SourceOf(picture)),
                               CountColors::OfDisparity(disparity_px_), width);
    case Picture::kDepth:
    case Picture::kFusedDepth: {
      const auto* rig = frame.Get<Rig>(Part::kRig);
      if (rig == nullptr) return {};
      return Drawing::OfCounts(frame.Get<DisparityImage>(SourceOf(picture)),
                               CountColors::OfDepth(rig->pair, depth_m_), width);
    }
    case Picture::kPrior:
      if (prior == nullptr) return {};
      return Drawing::OfCounts(&prior->disparity, CountColors::OfDisparity(disparity_px_), width);
    case Picture::kSigma:
      if (prior == nullptr || prior->empty()) return {};
      return Drawing::OfSigma(&prior->disparity, &prior->sigma, width);
    case Picture::kDisparitySigma:
      return Drawing::OfSigma(frame.Get<DisparityImage>(Part::kDisparity),
                              frame.Get<cv::Mat>(Part::kSigma), width);
  }
  return {};
}

EncodedPartPtr FrameEncoder::MakePicture(DecodedFrame& frame, Picture picture, int width) const {
  const std::optional<Drawing> drawing = Draw(frame, picture, width);
  if (!drawing) return nullptr;
  auto part = std::make_shared<EncodedPart>();
  part->head = {{"name", NameOf(picture)},
                {"width", drawing->image.cols},
                {"height", drawing->image.rows},
                {"full_width", drawing->full.width},
                {"full_height", drawing->full.height}};
  part->body = WriteJpeg(drawing->image, drawing->colors);
  return part;
}

EncodedPartPtr FrameEncoder::EncodePicture(const StoredFramePtr& frame, Picture picture,
                                           int width) {
  const std::shared_ptr<DecodedFrame> decoded = Decode(frame);
  const std::lock_guard lock(mutex_);
  return Cached(*frame, std::string(NameOf(picture)) + std::to_string(width), [&] {
    FollowRanges(*decoded);
    return MakePicture(*decoded, picture, width);
  });
}

std::string FrameEncoder::Encode(const StoredFramePtr& frame, const ShownParts& shown,
                                 const KeyRange& keys) {
  const std::shared_ptr<DecodedFrame> decoded = Decode(frame);
  const std::lock_guard lock(mutex_);
  FollowRanges(*decoded);
  std::vector<EncodedPartPtr> parts;
  const auto add = [&](const std::string& what, const auto& make) {
    if (EncodedPartPtr part = Cached(*frame, what, make)) parts.push_back(std::move(part));
  };
  for (const auto& [picture, width] : shown.pictures) {
    add(std::string(NameOf(picture)) + std::to_string(width),
        [&, picture = picture, width = width] { return MakePicture(*decoded, picture, width); });
  }
  if (shown.seeds) add("seeds", [&] { return EncodeSeeds(*decoded); });
  if (shown.cloud) add("cloud", [&] { return EncodeCloud(*decoded); });
  nlohmann::json head{{"type", "frame"},
                      {"key", frame->key},
                      {"version", frame->version},
                      {"seq", frame->id.seq},
                      {"utime", frame->id.utime},
                      {"rig_id", frame->id.rig_id},
                      {"keys", {keys.first, keys.last}},
                      {"scales",
                       {{"disparity", ScaleJson(disparity_px_, "px", "max")},
                        {"depth", ScaleJson(depth_m_, "m", "min")},
                        {"sigma", ScaleJson(kSigmaRange, "px", "none")},
                        {"confidence", ScaleJson({0, 1}, "", "none")}}}};
  if (const auto size = decoded->size()) {
    head["width"] = size->width;
    head["height"] = size->height;
  }
  for (const Part part : kAllParts) {
    if (frame->Has(part)) head["channels"].push_back(ChannelOf(part));
  }
  return MakePacket(std::move(head), parts);
}

nlohmann::json FrameEncoder::Probe(const StoredFramePtr& frame, int u, int v) {
  return ProbeJson(*Decode(frame), u, v);
}

}  // namespace sprout::view
