#include "services/depth/depth_adapter.h"

#include <algorithm>
#include <string>
#include <utility>

#include "common/core/image.h"
#include "services/depth/cloud.h"
#include "services/depth/depth_map.h"
#include "services/depth/depth_sigma.h"
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
  if (!frame.sigma.empty() && (frame.sigma.size() != size || frame.sigma.type() != CV_8UC1)) {
    return "SIGMA of " + SizeText(frame.sigma.size()) + " and " +
           std::to_string(frame.sigma.channels()) + " bytes a pixel: allowed is " + name + "'s " +
           SizeText(size) + ", in grey";
  }
  if (confidence.empty() || confidence.size() == size) return "";
  return "CONFIDENCE of " + SizeText(confidence.size()) + ": allowed is " + name + "'s " +
         SizeText(size);
}

}  // namespace

DepthAdapter::DepthAdapter(const DepthConfig& config) : config_(config) {
  RequireInRange(config, "depth");
  if (config.scale() == 3) throw ConfigError("depth.scale = 3: allowed: 1, 2, 4");
  if (!config.publish_depth() && !config.publish_cloud() && !config.publish_preview() &&
      !config.publish_sigma()) {
    throw ConfigError(
        "depth.publish_depth, depth.publish_cloud, depth.publish_preview, depth.publish_sigma = "
        "false: nothing to publish; allowed: at least one of them true");
  }
  if (config.publish_sigma() && config.input() == DepthConfig::FUSED) {
    throw ConfigError(
        "depth.publish_sigma = true: fused maps have no standard deviation; allowed: false with "
        "input: FUSED");
  }
}

PartSet DepthAdapter::Inputs() const {
  const Input& input = InputOf(config_);
  PartSet inputs{input.part, Part::kRig, Part::kLeft};
  if (config_.publish_cloud() && config_.confidence()) inputs.Add(input.confidence_part);
  if (config_.publish_sigma()) inputs.Add(Part::kSigma);
  return inputs;
}

StageResult DepthAdapter::Process(const Frame& frame) {
  StageResult result;
  if (frame.id.seq % config_.every() != 0) return result;
  const Input& input = InputOf(config_);
  result.degenerate = SizeComplaint(frame, input);
  if (!result.degenerate.empty()) return result;
  const DisparityImage& disparity = *(frame.*input.map);
  const RectifiedPair& pair = frame.rig->pair;
  if (config_.publish_depth() || config_.publish_sigma()) {
    const int scale = std::min({config_.scale(), pair.width, pair.height});
    DepthImage depth = DepthOf(disparity, pair, config_.mm_per_count() / 1000, scale);
    if (config_.publish_sigma()) {
      result.outputs.push_back(
          {Part::kDepthSigma, DepthSigmaOf(depth, disparity, frame.sigma, pair, scale)});
    }
    if (config_.publish_depth()) result.outputs.push_back({Part::kDepth, std::move(depth)});
  }
  if (config_.publish_cloud()) {
    const CloudThinning thinning{config_.cloud_stride(), config_.cloud_voxel_m()};
    result.outputs.push_back(
        {Part::kCloud, CloudOf(disparity, pair, frame.left, frame.*input.confidence, thinning)});
  }
  if (config_.publish_preview()) {
    result.preview = PreviewOf(frame.left, disparity, pair);
  }
  return result;
}

}  // namespace sprout::depth
