#pragma once

#include "common/config/stage_parts.h"
#include "common/core/stage_adapter.h"
#include "services/temporal/temporal_filter.h"

namespace sprout::temporal {

/// LEFT RIG DISPARITY CONFIDENCE [ODOMETRY] → FUSED FUSED_CONFIDENCE MOTION. A stage with memory:
/// answers depend on the frames since it was made.
class TemporalAdapter : public StageAdapter {
 public:
  /// @throws ConfigError for a value out of range.
  explicit TemporalAdapter(const TemporalConfig& config) : config_(config), filter_(config) {}

  PartSet Inputs() const override { return InputsOf(config_); }

  /// Always answers. The result says why the memory was lost, but for the first frame. Parts of
  /// different sizes give no disparity, and change nothing that is remembered.
  StageResult Process(const Frame& frame) override;

  int WarmUpFrames() const override { return config_.warm_up_frames(); }

  /// Forgets all frames.
  void Reset() { filter_.Reset(); }

 private:
  TemporalConfig config_;
  TemporalFilter filter_;
};

}  // namespace sprout::temporal
