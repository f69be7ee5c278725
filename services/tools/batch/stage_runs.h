#ifndef SPROUT_SERVICES_TOOLS_BATCH_STAGE_RUNS_H_
#define SPROUT_SERVICES_TOOLS_BATCH_STAGE_RUNS_H_

#include <filesystem>
#include <optional>
#include <string>

#include "services/tools/batch/manifest.h"

namespace sprout::batch {

/// The counts that a stage printed at the end of a replay; nothing when it printed none.
std::optional<StageRun> ParseReplayReport(const std::string& output);

/// The counts of a result, one for each stage.
/// @throws LogError when they cannot be read, or lack a stage.
StageRuns ReadStageRuns(const std::filesystem::path& result, const Manifest& manifest);

}  // namespace sprout::batch

#endif  // SPROUT_SERVICES_TOOLS_BATCH_STAGE_RUNS_H_
