#include "services/pipeline/step_monitors.h"

#include "common/core/tof_coverage.h"

namespace sprout {

StepMonitors::StepMonitors(const std::string& config_digest)
    : monitors_{StageMonitor("refine", config_digest), StageMonitor("prior", config_digest),
                StageMonitor("grow", config_digest)} {}

void StepMonitors::Begins(ChainStep step) {
  // Filling gaps is a part of growth.
  if (step != ChainStep::kFinish) begun_ = StageMonitor::Clock::now();
}

void StepMonitors::Answered(std::string_view stage, const Frame& frame,
                            const StageResult& outcome) {
  StageMonitor& monitor = monitors_[stage == "refine" ? 0 : stage == "prior" ? 1 : 2];
  monitor.FrameIn(/*skipped=*/false);
  monitor.SetTofOffset(outcome.tof_offset);
  monitor.FrameOut(frame.id, begun_, outcome.degenerate,
                   TofCoverage(frame.seeds->seeds, frame.left.size()));
}

}  // namespace sprout
