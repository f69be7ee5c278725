#include "common/app/run_stage.h"

#include "common/app/live.h"
#include "common/app/replay.h"
#include "common/app/service.h"

namespace sprout {

int RunStage(int argc, char** argv, const std::string& stage, const std::string& description,
             const MakeAdapter& make_adapter, const std::string& program) {
  Service service(stage, description, program);
  service.OfferReplay();
  return service.Run(argc, argv, [&](const ServiceContext& context) {
    const std::unique_ptr<StageAdapter> adapter = make_adapter(context.config);
    if (context.replay) return RunReplay(context, *context.replay, *adapter);
    RunLive(context, *adapter);
    return 0;
  });
}

}  // namespace sprout
