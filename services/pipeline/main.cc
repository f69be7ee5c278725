
#include "common/app/live.h"
#include "common/app/replay.h"
#include "common/app/service.h"
#include "common/core/digest.h"
#include "services/pipeline/files/files.h"
#include "services/pipeline/files/flags.h"
#include "services/pipeline/pipeline_adapter.h"
#include "services/pipeline/step_monitors.h"

namespace sprout {
namespace {

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
