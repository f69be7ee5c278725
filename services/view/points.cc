#include "services/view/points.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace sprout::view {
namespace {

enum class SeedKind : uint8_t { kTof = 0, kStereo = 1, kLeftOnly = 2 };

SeedKind KindOf(const Seed& seed, Part part) {
  if (part == Part::kLeftSeeds) return SeedKind::kLeftOnly;
  return seed.origin == SeedOrigin::kStereo ? SeedKind::kStereo : SeedKind::kTof;
}

std::string_view NameOf(SeedKind kind) {
  constexpr std::array<std::string_view, 3> kNames = {"ToF", "stereo", "ToF, left camera only"};
  return kNames[static_cast<size_t>(kind)];
}

template <typename Visit>
void ForEachSeed(DecodedFrame& frame, const Visit& visit) {
  for (const Part part : {Part::kSeeds, Part::kLeftSeeds}) {
    const auto* set = frame.Get<SeedSet>(part);
    if (set == nullptr) continue;
    for (const Seed& seed : set->seeds) visit(seed, KindOf(seed, part));
  }
}

// The value of a map at a pixel; nothing beyond it, since a stage may send a map of another size.
template <typename T>
std::optional<T> ValueAt(const cv::Mat& map, int u, int v) {
  if (u < 0 || v < 0 || u >= map.cols || v >= map.rows) return std::nullopt;
  return map.at<T>(v, u);
}

// The disparity at a pixel, px; nothing where there is none.
std::optional<double> PxAt(const DisparityImage& map, int u, int v) {
  const auto count = ValueAt<int16_t>(map.counts(), u, v);
  if (!count || *count == DisparityImage::kInvalid) return std::nullopt;
  return static_cast<double>(*count) / DisparityImage::kCountsPerPixel;
}

int16_t ToInt16(float value) {
  return static_cast<int16_t>(std::lround(std::clamp(value, -32768.0F, 32767.0F)));
}

}  // namespace

EncodedPartPtr EncodeCloud(DecodedFrame& frame) {
  const auto* map = frame.Get<DisparityImage>(Part::kDisparity);
  const auto* left = frame.Get<cv::Mat>(Part::kLeft);
  const auto* rig = frame.Get<Rig>(Part::kRig);
  if (map == nullptr || left == nullptr || rig == nullptr || map->empty()) return nullptr;
  if (left->size() != map->size() || rig->pair.size() != map->size()) return nullptr;
  const auto* confidence = frame.Get<cv::Mat>(Part::kConfidence);
  const bool has_confidence =
      confidence != nullptr && confidence->size() == map->size() && confidence->type() == CV_8UC1;
  const double pixels = static_cast<double>(map->counts().total());
  const int stride = std::max(1, static_cast<int>(std::ceil(std::sqrt(pixels / kMaxShownPoints))));
  const int columns = (map->width() + stride - 1) / stride;
  const int rows = (map->height() + stride - 1) / stride;
  std::vector<int16_t> counts;
  std::vector<uint8_t> colors;
  std::vector<uint8_t> trust;
  for (int v = 0; v < map->height(); v += stride) {
    for (int u = 0; u < map->width(); u += stride) {
      counts.push_back(map->counts()(v, u));
      const cv::Vec3b bgr =
          left->channels() == 3 ? left->at<cv::Vec3b>(v, u) : cv::Vec3b::all(left->at<uchar>(v, u));
      colors.insert(colors.end(), {bgr[2], bgr[1], bgr[0]});
      if (has_confidence) trust.push_back(confidence->at<uchar>(v, u));
    }
  }
  auto part = std::make_shared<EncodedPart>();
  const RectifiedPair& pair = rig->pair;
  part->head = {{"name", "cloud"},
                {"columns", columns},
                {"rows", rows},
                {"stride", stride},
                {"counts_per_px", DisparityImage::kCountsPerPixel},
                {"invalid", DisparityImage::kInvalid},
                {"focal_px", pair.focal_px},
                {"cx", pair.cx},
                {"cy", pair.cy},
                {"cx_right", pair.cx_right},
                {"baseline_m", pair.baseline_m},
                {"has_confidence", has_confidence}};
  AppendNumbers(part->body, counts);
  AppendNumbers(part->body, colors);
  AppendNumbers(part->body, trust);
  return part;
}

EncodedPartPtr EncodeSeeds(DecodedFrame& frame) {
  if (!frame.stored().Has(Part::kSeeds) && !frame.stored().Has(Part::kLeftSeeds)) return nullptr;
  std::array<int64_t, 3> totals{};
  int64_t total = 0;
  ForEachSeed(frame, [&](const Seed&, SeedKind kind) {
    ++totals[static_cast<size_t>(kind)];
    ++total;
  });
  const int64_t step = (total + kMaxShownSeeds - 1) / kMaxShownSeeds;
  std::vector<int16_t> us;
  std::vector<int16_t> vs;
  std::vector<int16_t> disparities;
  std::vector<uint8_t> kinds;
  int64_t i = 0;
  ForEachSeed(frame, [&](const Seed& seed, SeedKind kind) {
    if (i++ % step != 0) return;
    us.push_back(ToInt16(seed.u));
    vs.push_back(ToInt16(seed.v));
    disparities.push_back(ToCounts(seed.disparity()));
    kinds.push_back(static_cast<uint8_t>(kind));
  });
  auto part = std::make_shared<EncodedPart>();
  part->head = {{"name", "seeds"},
                {"count", us.size()},
                {"total", total},
                {"tof", totals[0]},
                {"stereo", totals[1]},
                {"left_only", totals[2]},
                {"counts_per_px", DisparityImage::kCountsPerPixel}};
  if (const auto* set = frame.Get<SeedSet>(Part::kSeeds)) part->head["raw"] = set->raw;
  AppendNumbers(part->body, us);
  AppendNumbers(part->body, vs);
  AppendNumbers(part->body, disparities);
  AppendNumbers(part->body, kinds);
  return part;
}

namespace {

void AddMaps(DecodedFrame& frame, int u, int v, nlohmann::json& json) {
  const auto* rig = frame.Get<Rig>(Part::kRig);
  if (const auto* map = frame.Get<DisparityImage>(Part::kDisparity)) {
    if (const auto px = PxAt(*map, u, v)) {
      json["disparity_px"] = *px;
      const double depth_m = rig == nullptr ? 0 : rig->pair.DepthFromDisparity(*px);
      if (depth_m > 0 && std::isfinite(depth_m)) json["depth_m"] = depth_m;
    }
  }
  if (const auto* fused = frame.Get<DisparityImage>(Part::kFused)) {
    if (const auto px = PxAt(*fused, u, v)) json["fused_px"] = *px;
  }
  if (const auto* prior = frame.Get<PriorMap>(Part::kPrior)) {
    if (const auto px = PxAt(prior->disparity, u, v)) {
      json["prior_px"] = *px;
      json["sigma_px"] = SigmaToPx(prior->sigma(v, u));
    }
  }
}

void AddPixels(DecodedFrame& frame, int u, int v, nlohmann::json& json) {
  if (const auto* confidence = frame.Get<cv::Mat>(Part::kConfidence)) {
    const auto count =
        confidence->channels() == 1 ? ValueAt<uchar>(*confidence, u, v) : std::nullopt;
    if (count) json["confidence"] = *count / 255.0;
  }
  if (const auto* sigma = frame.Get<cv::Mat>(Part::kSigma); json.contains("disparity_px")) {
    const auto count =
        sigma != nullptr && sigma->channels() == 1 ? ValueAt<uchar>(*sigma, u, v) : std::nullopt;
    if (count) json["disparity_sigma_px"] = SigmaToPx(*count);
  }
  if (const auto* left = frame.Get<cv::Mat>(Part::kLeft)) {
    if (left->channels() == 1) {
      if (const auto grey = ValueAt<uchar>(*left, u, v)) json["grey"] = *grey;
    } else if (const auto bgr = ValueAt<cv::Vec3b>(*left, u, v)) {
      json["rgb"] = {(*bgr)[2], (*bgr)[1], (*bgr)[0]};
    }
  }
}

void AddNearestSeed(DecodedFrame& frame, int u, int v, nlohmann::json& json) {
  std::optional<std::pair<Seed, SeedKind>> nearest;
  double least = 0;
  ForEachSeed(frame, [&](const Seed& seed, SeedKind kind) {
    const double distance =
        std::hypot(seed.u - static_cast<float>(u), seed.v - static_cast<float>(v));
    if (nearest && distance >= least) return;
    least = distance;
    nearest.emplace(seed, kind);
  });
  if (!nearest) return;
  const auto& [seed, kind] = *nearest;
  json["seed"] = {{"u", seed.u},
                  {"v", seed.v},
                  {"disparity_px", seed.disparity()},
                  {"sigma_px", seed.sigma_px},
                  {"origin", NameOf(kind)},
                  {"distance_px", least}};
  if (seed.tof_u >= 0) {
    json["seed"]["tof_u"] = seed.tof_u;
    json["seed"]["tof_v"] = seed.tof_v;
  }
}

}  // namespace

nlohmann::json ProbeJson(DecodedFrame& frame, int u, int v) {
  nlohmann::json json{{"key", frame.stored().key}, {"u", u}, {"v", v}};
  AddMaps(frame, u, v, json);
  AddPixels(frame, u, v, json);
  AddNearestSeed(frame, u, v, json);
  return json;
}

}  // namespace sprout::view
