#include <algorithm>
#include <array>
#include <cassert>
#include <span>
#include <string>
#include <string_view>

#include "common/app/live.h"
#include "common/app/replay.h"
#include "common/app/service.h"
#include "common/app/stage_monitor.h"
#include "common/core/digest.h"
#include "common/core/tof_coverage.h"
#include "services/pipeline/chain.h"
#include "services/pipeline/files/files.h"
#include "services/pipeline/files/flags.h"
#include "services/pipeline/pipeline_adapter.h"

namespace sprout {
namespace {

constexpr std::array<std::string_view, 4> kStages = {"refine", "prior", "grow", "temporal"};

// Counts and times refine, prior, grow and temporal inside a chain under these names, as if they
// were processes: for capture's --wait-for, sprout-top and the like. A frame that fails, or is
// lost before the chain, is counted only by the process that runs the chain.
class StepMonitors : public ChainObserver {
 public:
  // @param temporal  whether the chain has that step.
  StepMonitors(const std::string& config_digest, bool temporal)
      : monitors_{StageMonitor("refine", config_digest), StageMonitor("prior", config_digest),
                  StageMonitor("grow", config_digest), StageMonitor("temporal", config_digest)},
        count_(temporal ? 4 : 3) {}

  std::span<StageMonitor> all() { return std::span(monitors_).first(count_); }

  void Begins(ChainStep step) override {
    // Filling gaps is a part of growth.
    if (step != ChainStep::kFinish) begun_ = StageMonitor::Clock::now();
  }

  void Answered(std::string_view stage, const Frame& frame, const StageResult& outcome) override {
    const auto it = std::ranges::find(kStages, stage);
    assert(it != kStages.end());
    StageMonitor& monitor = monitors_[static_cast<size_t>(it - kStages.begin())];
    monitor.FrameIn(/*skipped=*/false);
    monitor.SetTofOffset(outcome.tof_offset);
    monitor.SetRangeError(outcome.range_error);
    monitor.FrameOut(frame.id, begun_, outcome.degenerate,
                     stage == "temporal" ? kUnknownCoverage
                                         : TofCoverage(frame.seeds->seeds, frame.left.size()));
  }

 private:
  std::array<StageMonitor, 4> monitors_;
  size_t count_;
  StageMonitor::Clock::time_point begun_{};
};

constexpr char kDescription[] =
    "refine, prior and grow in one process, where cores are few: the same messages and bytes, but\n"
    "images are received and decoded once. Joins SPROUT_LEFT, SPROUT_RIGHT, SPROUT_TOF and\n"
    "SPROUT_RIG; publishes SPROUT_SEEDS, SPROUT_LEFT_SEEDS, SPROUT_PRIOR, SPROUT_DISPARITY and "
    "what\n"
    "else the configuration asks for, and the statuses of all three; with temporal { in_pipeline:\n"
    "true } also what sprout-temporal does. `sprout-pipeline files --help`: depth of image files,\n"
    "without any bus.";

int Main(int argc, char** argv) {
  Service service("pipeline", kDescription);
  service.OfferReplay();
  FilesOptions files;
  const Flags& files_command = AddFilesCommand(service.flags(), files);
  return service.Run(argc, argv, [&](const ServiceContext& context) {
    if (files_command.IsGiven()) return RunFiles(files, context.config, context.stop);
    StepMonitors steps(Digest(ConfigText(context.config)), context.config.temporal().in_pipeline());
    PipelineAdapter adapter(context.config, steps);
    if (context.replay) return RunReplay(context, *context.replay, adapter);
    RunLive(context, adapter, steps.all());
    return 0;
  });
}

}  // namespace

}  // namespace sprout

int main(int argc, char** argv) { return sprout::Main(argc, argv); }
