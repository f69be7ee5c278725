#include "services/pipeline/files/believe_nothing.h"

#include <limits>

#include "common/core/prior_map.h"

namespace sprout {

void BelieveNothing(const SproutConfig& config, DepthFrame& depth) {
  const bool has_confidence = !depth.confidence.empty();
  for (cv::Mat1b* confidence : {&depth.confidence, &depth.fused_confidence}) *confidence = 0;
  depth.sigma = kMaxSigmaCounts;
  const bool of_fused = config.depth().input() == DepthConfig::FUSED;
  const auto drop_all = [](DisparityImage& map) { map.counts() = DisparityImage::kInvalid; };
  if (!has_confidence) return;
  const bool drops = config.grow().min_confidence() > 0;
  if (drops) drop_all(depth.disparity);
  if (config.depth().min_confidence() > 0 || (drops && !of_fused)) {
    drop_all(depth.kept);
    depth.depth_m = std::numeric_limits<float>::quiet_NaN();
  }
}

}  // namespace sprout
