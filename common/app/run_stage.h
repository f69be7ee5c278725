#ifndef SPROUT_COMMON_APP_RUN_STAGE_H_
#define SPROUT_COMMON_APP_RUN_STAGE_H_

#include <functional>
#include <memory>
#include <string>

#include "common/config/config.h"
#include "common/core/plug.h"

namespace sprout {

/// Creates the plug of a stage from the effective configuration.
using MakePlug = std::function<std::unique_ptr<Plug>(const SproutConfig&)>;

/// The whole main of a service that is one plug: runs it live until a signal comes, or over logs
/// (--replay).
int RunStage(int argc, char** argv, const std::string& stage, const std::string& description,
             const MakePlug& make_plug);

}  // namespace sprout

#endif  // SPROUT_COMMON_APP_RUN_STAGE_H_
