#include "services/depth/depth_adapter.h"

#include <algorithm>
#include <string>

#include "common/core/image.h"
#include "services/depth/cloud.h"
#include "services/depth/depth_map.h"
#include "services/depth/preview.h"

namespace sprout::depth {
namespace {

std::string SizeComplaint(const Frame& frame) {
  const cv::Size size = frame.disparity->size();
  if (frame.rig->pair.size() != size) {
    return "DISPARITY of " + SizeText(size) + ": allowed is the calibrated size " +
           SizeText(frame.rig->pair.size());
  }
  if (frame.left.size() != size) {
    return "LEFT of " + SizeText(frame.left.size()) + ": allowed is DISPARITY's " + SizeText(size);
  }
  if (frame.confidence.empty() || frame.confidence.size() == size) return "";
  return "CONFIDENCE of " + SizeText(frame.confidence.size()) + ": allowed is DISPARITY's " +
         SizeText(size);
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
  PartSet inputs{Part::kDisparity, Part::kRig, Part::kLeft};
  if (config_.publish_cloud() && config_.confidence()) inputs.Add(Part::kConfidence);
  return inputs;
}

StageResult DepthAdapter::Process(const Frame& frame) {
  StageResult result;
  if (frame.id.seq % config_.every() != 0) return result;
  result.degenerate = SizeComplaint(frame);
  if (!result.degenerate.empty()) return result;
  const RectifiedPair& pair = frame.rig->pair;
  if (config_.publish_depth()) {
    const int scale = std::min({config_.scale(), pair.width, pair.height});
    result.outputs.push_back(
        {Part::kDepth, DepthOf(*frame.disparity, pair, config_.mm_per_count() / 1000, scale)});
  }
  if (config_.publish_cloud()) {
    const CloudThinning thinning{config_.cloud_stride(), config_.cloud_voxel_m()};
    result.outputs.push_back(
        {Part::kCloud, CloudOf(*frame.disparity, pair, frame.left, frame.confidence, thinning)});
  }
  if (config_.publish_preview()) {
    result.preview = PreviewOf(frame.left, *frame.disparity, pair);
  }
  return result;
}

}  // namespace sprout::depth
