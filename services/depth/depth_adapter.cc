#include "services/depth/depth_adapter.h"

#include <algorithm>
#include <string>
#include <utility>

#include "common/core/image.h"
#include "services/depth/cloud.h"
#include "services/depth/depth_map.h"
#include "services/depth/preview.h"

namespace sprout::depth {
namespace {

// The map that the configuration chooses.
struct Input {
  Part part, confidence_part;
  const char* name;
  std::optional<DisparityImage> Frame::*map;
  cv::Mat Frame::*confidence;
};
constexpr Input kSingle{Part::kDisparity, Part::kConfidence, "DISPARITY", &Frame::disparity,
                        &Frame::confidence};
constexpr Input kFused{Part::kFused, Part::kFusedConfidence, "FUSED", &Frame::fused,
                       &Frame::fused_confidence};

const Input& InputOf(const DepthConfig& config) {
  return config.input() == DepthConfig::FUSED ? kFused : kSingle;
}

std::string SizeComplaint(const Frame& frame, const Input& input) {
  const cv::Size size = (frame.*input.map)->size();
  const cv::Mat& confidence = frame.*input.confidence;
  const std::string name = input.name;
  if (frame.rig->pair.size() != size) {
    return name + " of " + SizeText(size) + ": allowed is the calibrated size " +
           SizeText(frame.rig->pair.size());
  }
  if (frame.left.size() != size) {
    return "LEFT of " + SizeText(frame.left.size()) + ": allowed is " + name + "'s " +
           SizeText(size);
  }
  if (confidence.empty() || confidence.size() == size) return "";
  return "CONFIDENCE of " + SizeText(confidence.size()) + ": allowed is " + name + "'s " +
         SizeText(size);
}

}  // namespace

DepthAdapter::DepthAdapter(const DepthConfig& config)
    : config_(config), options_(OptionsOf(config)), filter_(options_.filter) {}

PartSet DepthAdapter::Inputs() const {
  const Input& input = InputOf(config_);
  PartSet inputs{input.part, Part::kRig, Part::kLeft};
  const bool has_points = config_.publish_cloud() || config_.min_confidence() > 0;
  if (has_points && config_.confidence()) inputs.Add(input.confidence_part);
  return inputs;
}

StageResult DepthAdapter::Process(const Frame& frame) {
  StageResult result;
  if (frame.id.seq % config_.every() != 0) return result;
  const Input& input = InputOf(config_);
  result.degenerate = SizeComplaint(frame, input);
  if (!result.degenerate.empty()) return result;
  const RectifiedPair& pair = frame.rig->pair;
  result.degenerate = RigComplaint(options_, pair);
  const bool is_placed = result.degenerate.empty();
  if (!is_placed && options_.filter.box) return result;
  Seen seen{*(frame.*input.map), pair, frame.left, frame.*input.confidence};
  if (!filter_.IsOff()) {
    DepthCounts counts;
    seen.disparity = filter_.Apply(seen.disparity, pair, seen.confidence, counts);
    result.outputs.push_back({Part::kDepthCounts, counts});
  }
  AddOfLeft(seen, result);
  if (is_placed) AddOfOtherPlaces(seen, result);
  if (config_.publish_preview()) result.preview = PreviewOf(frame.left, seen.disparity, pair);
  return result;
}

void DepthAdapter::AddOfLeft(const Seen& seen, StageResult& result) const {
  const RectifiedPair& pair = seen.pair;
  if (config_.publish_depth()) {
    const int scale = std::min({config_.scale(), pair.width, pair.height});
    result.outputs.push_back(
        {Part::kDepth, DepthOf(seen.disparity, pair, config_.mm_per_count() / 1000, scale)});
  }
  if (config_.publish_cloud()) {
    result.outputs.push_back(
        {Part::kCloud, CloudOf(seen.disparity, pair, seen.left, seen.confidence, Thinning())});
  }
}

void DepthAdapter::AddOfOtherPlaces(const Seen& seen, StageResult& result) const {
  const RectifiedPair& pair = seen.pair;
  if (config_.publish_cloud() && options_.base_from_left) {
    const PointCloud cloud = CloudOf(seen.disparity, pair, seen.left, seen.confidence, Thinning());
    result.outputs.push_back({Part::kBaseCloud, Moved(cloud, *options_.base_from_left)});
  }
  if (options_.target) {
    const View& view = *options_.target;
    DepthImage depth = DepthInView(seen.disparity, pair, view, config_.mm_per_count() / 1000);
    if (config_.publish_cloud()) {
      result.outputs.push_back({Part::kTargetCloud, CloudInView(depth, view, pair, seen.left,
                                                                seen.confidence, Thinning())});
    }
    result.outputs.push_back({Part::kTargetDepth, std::move(depth)});
  }
  if (!options_.scan) return;
  Result<PlanarScan> scan = ScanOf(
      seen.disparity, pair, options_.base_from_left.value_or(LevelFromLeft()), *options_.scan);
  if (scan) {
    result.scan = std::move(*scan);
  } else {
    result.degenerate = scan.error().text;
  }
}

}  // namespace sprout::depth
