#include "common/app/run_stage.h"

#include "common/app/live.h"
#include "common/app/replay.h"
#include "common/app/service.h"

namespace sprout {

int RunStage(int argc, char** argv, const std::string& stage, const std::string& description,
             const MakePlug& make_plug) {
  Service service(stage, description);
  service.OfferReplay();
  return service.Run(argc, argv, [&](const ServiceContext& context) {
    const std::unique_ptr<Plug> plug = make_plug(context.config);
    if (context.replay) return RunReplay(context, *context.replay, *plug);
    RunLive(context, *plug);
    return 0;
  });
}

}  // namespace sprout
