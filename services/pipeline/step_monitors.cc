#include "services/pipeline/step_monitors.h"

#include <algorithm>
#include <cassert>

#include "common/core/tof_coverage.h"

namespace sprout {
namespace {

constexpr std::array<std::string_view, 4> kStages = {"refine", "prior", "grow", "temporal"};

}  // namespace

StepMonitors::StepMonitors(const std::string& config_digest, bool temporal)
    : monitors_{StageMonitor("refine", config_digest), StageMonitor("prior", config_digest),
                StageMonitor("grow", config_digest), StageMonitor("temporal", config_digest)},
      count_(temporal ? 4 : 3) {}

void StepMonitors::Begins(ChainStep step) {
  // Filling gaps is a part of growth.
  if (step != ChainStep::kFinish) begun_ = StageMonitor::Clock::now();
}

void StepMonitors::Answered(std::string_view stage, const Frame& frame,
                            const StageResult& outcome) {
  const auto it = std::ranges::find(kStages, stage);
  assert(it != kStages.end());
  StageMonitor& monitor = monitors_[static_cast<size_t>(it - kStages.begin())];
  monitor.FrameIn(/*skipped=*/false);
  monitor.SetTofOffset(outcome.tof_offset);
  monitor.SetRangeError(outcome.range_error);
  monitor.FrameOut(
      frame.id, begun_, outcome.degenerate,
      stage == "temporal" ? kUnknownCoverage : TofCoverage(frame.seeds->seeds, frame.left.size()));
}

}  // namespace sprout
