#pragma once

#include "common/config/config.h"
#include "common/core/stage_adapter.h"
#include "services/pipeline/chain.h"

namespace sprout {

/// LEFT RIGHT TOF RIG [ODOMETRY] → SEEDS LEFT_SEEDS PRIOR [UNFILLED] DISPARITY [CONFIDENCE SIGMA]
/// [FUSED FUSED_CONFIDENCE MOTION]: what refine, prior and grow answer with the same configuration,
/// and with temporal.in_pipeline also temporal, to the byte. Then it is a stage with memory.
class PipelineAdapter : public StageAdapter {
 public:
  /// @param steps  observes every step; must outlive this object.
  /// @throws ConfigError as Chain.
  PipelineAdapter(const SproutConfig& config, ChainObserver& steps);

  PartSet Inputs() const override;

  /// Only temporal needs to know how the camera moved: without that it forgets earlier frames.
  PartSet OptionalInputs() const override { return {Part::kOdometry}; }

  /// Always answers. The result's reason names the stages that had nothing to give. The ToF
  /// camera's pose that refine measured is reported to the observer only.
  StageResult Process(const Frame& frame) override;

  int WarmUpFrames() const override { return warm_up_frames_; }

 private:
  ChainObserver& steps_;
  PartSet inputs_;
  PartSet outputs_;
  bool grows_with_prior_;
  int warm_up_frames_;
  Chain chain_;
};

}  // namespace sprout
