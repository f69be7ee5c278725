#include "services/depth/depth_adapter.h"

#include <algorithm>
#include <string>

#include "common/core/image.h"
#include "services/depth/cloud.h"
#include "services/depth/depth_map.h"
#include "services/depth/preview.h"

namespace sprout::depth {
namespace {

// The parts that the configuration chooses.
struct Input {
  Part map_part, confidence_part;
};
Input InputOf(const DepthConfig& config) {
  if (config.input() == DepthConfig::FUSED) return {Part::kFused, Part::kFusedConfidence};
  return {Part::kDisparity, Part::kConfidence};
}

std::string SizeComplaint(const Frame& frame, const char* name, cv::Size size,
                          cv::Size confidence) {
  if (frame.rig->pair.size() != size) {
    return std::string(name) + " of " + SizeText(size) + ": allowed is the calibrated size " +
           SizeText(frame.rig->pair.size());
  }
  if (frame.left.size() != size) {
    return "LEFT of " + SizeText(frame.left.size()) + ": allowed is " + name + "'s " +
           SizeText(size);
  }
  if (confidence.empty() || confidence == size) return "";
  return "CONFIDENCE of " + SizeText(confidence) + ": allowed is " + name + "'s " + SizeText(size);
}

}  // namespace

DepthAdapter::DepthAdapter(const DepthConfig& config) : config_(config) {
  RequireInRange(config, "depth");
  if (config.scale() == 3) throw ConfigError("depth.scale = 3: allowed: 1, 2, 4");
  if (!config.publish_depth() && !config.publish_cloud() && !config.publish_preview()) {
    throw ConfigError(
        "depth.publish_depth, depth.publish_cloud, depth.publish_preview = false: nothing to "
        "publish; allowed: at least one of them true");
  }
}

PartSet DepthAdapter::Inputs() const {
  const Input input = InputOf(config_);
  PartSet inputs{input.map_part, Part::kRig, Part::kLeft};
  if (config_.publish_cloud() && config_.confidence()) inputs.Add(input.confidence_part);
  return inputs;
}

StageResult DepthAdapter::Process(const Frame& frame) {
  StageResult result;
  if (frame.id.seq % config_.every() != 0) return result;
  const bool is_fused = config_.input() == DepthConfig::FUSED;
  const DisparityImage& disparity = is_fused ? *frame.fused : *frame.disparity;
  const cv::Mat& confidence = is_fused ? frame.fused_confidence : frame.confidence;
  result.degenerate =
      SizeComplaint(frame, is_fused ? "FUSED" : "DISPARITY", disparity.size(), confidence.size());
  if (!result.degenerate.empty()) return result;
  const RectifiedPair& pair = frame.rig->pair;
  if (config_.publish_depth()) {
    const int scale = std::min({config_.scale(), pair.width, pair.height});
    result.outputs.push_back(
        {Part::kDepth, DepthOf(disparity, pair, config_.mm_per_count() / 1000, scale)});
  }
  if (config_.publish_cloud()) {
    const CloudThinning thinning{config_.cloud_stride(), config_.cloud_voxel_m()};
    result.outputs.push_back(
        {Part::kCloud, CloudOf(disparity, pair, frame.left, confidence, thinning)});
  }
  if (config_.publish_preview()) {
    result.preview = PreviewOf(frame.left, disparity, pair);
  }
  return result;
}

}  // namespace sprout::depth
