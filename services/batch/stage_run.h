#ifndef SPROUT_SERVICES_BATCH_STAGE_RUN_H_
#define SPROUT_SERVICES_BATCH_STAGE_RUN_H_

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "services/batch/stage_chain.h"

namespace sprout::batch {

/// Counts and times of a stage over one shard.
struct StageRun {
  int64_t frames_in = 0;
  int64_t frames_out = 0;
  int64_t degenerate = 0;  ///< answered, with an empty map
  int64_t failed = 0;      ///< not answered
  int64_t bad_messages = 0;
  double seconds = 0;  ///< wall time of the program, its start included
};

/// By stage.
using StageRuns = std::map<std::string, StageRun>;

/// The counts that a stage printed at the end of a replay; nothing when it printed none.
std::optional<StageRun> ParseReplayReport(const std::string& output);

/// run.json: kept beside the answers of a shard, with the name of this machine. @throws LogError.
void WriteStageRuns(const std::filesystem::path& path, const StageRuns& runs);

/// @throws LogError when it cannot be read, or lacks one of the stages.
StageRuns ReadStageRuns(const std::filesystem::path& path, const StageNames& stages);

}  // namespace sprout::batch

#endif  // SPROUT_SERVICES_BATCH_STAGE_RUN_H_
