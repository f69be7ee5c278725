#ifndef SPROUT_SERVICES_PIPELINE_STEP_MONITORS_H_
#define SPROUT_SERVICES_PIPELINE_STEP_MONITORS_H_

#include <array>
#include <span>
#include <string>
#include <string_view>

#include "common/app/stage_monitor.h"
#include "services/pipeline/chain.h"

namespace sprout {

/// Counts and times refine, prior, grow and temporal inside a chain under these names, as if they
/// were processes: for capture's --wait-for, sprout-top and the like. A frame that fails, or is
/// lost before the chain, is counted only by the process that runs the chain.
class StepMonitors : public ChainObserver {
 public:
  /// @param temporal  whether the chain has that step.
  StepMonitors(const std::string& config_digest, bool temporal);

  std::span<StageMonitor> all() { return std::span(monitors_).first(count_); }

  void Begins(ChainStep step) override;
  void Answered(std::string_view stage, const Frame& frame, const StageResult& outcome) override;

 private:
  std::array<StageMonitor, 4> monitors_;
  size_t count_;
  StageMonitor::Clock::time_point begun_{};
};

}  // namespace sprout

#endif  // SPROUT_SERVICES_PIPELINE_STEP_MONITORS_H_
