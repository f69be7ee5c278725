#ifndef SPROUT_SERVICES_DEPTH_DEPTH_ADAPTER_H_
#define SPROUT_SERVICES_DEPTH_DEPTH_ADAPTER_H_

#include "common/config/config.h"
#include "common/core/stage_adapter.h"

namespace sprout::depth {

/// DISPARITY LEFT RIG → DEPTH, CLOUD, a preview, as the configuration says; CONFIDENCE is joined
/// for the cloud, SIGMA for DEPTH_SIGMA if the configuration says so. With input FUSED: FUSED and
/// FUSED_CONFIDENCE instead, and no DEPTH_SIGMA.
class DepthAdapter : public StageAdapter {
 public:
  /// @throws ConfigError for a value out of range, and when nothing is to be published.
  explicit DepthAdapter(const DepthConfig& config);

  PartSet Inputs() const override;

  /// Answers nothing for a frame that `every` skips, and for one whose images, map and calibration
  /// differ in size; the result says why.
  StageResult Process(const Frame& frame) override;

 private:
  DepthConfig config_;
};

}  // namespace sprout::depth

#endif  // SPROUT_SERVICES_DEPTH_DEPTH_ADAPTER_H_
