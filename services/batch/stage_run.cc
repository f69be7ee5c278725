#include "services/batch/stage_run.h"

#include <cinttypes>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "common/core/host_name.h"
#include "common/core/printable.h"
#include "common/logfile/log_error.h"
#include "services/batch/json_fields.h"
#include "services/batch/names.h"
#include "services/batch/text_file.h"

namespace sprout::batch {

using Json = nlohmann::json;

std::optional<StageRun> ParseReplayReport(const std::string& output) {
  StageRun run;
  const size_t at = output.find(" events; frames: ");
  if (at == std::string::npos ||
      std::sscanf(
          output.c_str() + at,
          " events; frames: %" SCNd64 " in, %" SCNd64 " out (%" SCNd64 " degenerate), %" SCNd64
          " failed, %*d incomplete, %*d left out; %" SCNd64 " bad messages",
          &run.frames_in, &run.frames_out, &run.degenerate, &run.failed, &run.bad_messages) != 5) {
    return std::nullopt;
  }
  return run;
}

void WriteStageRuns(const std::filesystem::path& path, const StageRuns& runs) {
  Json stages = Json::object();
  for (const auto& [stage, run] : runs) {
    stages[stage] = {{"in", run.frames_in},          {"out", run.frames_out},
                     {"degenerate", run.degenerate}, {"failed", run.failed},
                     {"bad", run.bad_messages},      {"seconds", run.seconds}};
  }
  OutputFile file(path);
  file.Write(Json{{"host", Printable(HostName())}, {"stages", stages}}.dump() + "\n");
  CommitFile(path, file);
}

StageRuns ReadStageRuns(const std::filesystem::path& path, const StageNames& stages) {
  StageRuns runs;
  try {
    const Json json = ParseObject(FirstLineOf(path));
    for (const std::string& stage : stages) {
      const Json& run = ObjectIn(ObjectIn(json, "stages"), stage);
      runs[stage] = {.frames_in = CountIn(run, "in"),
                     .frames_out = CountIn(run, "out"),
                     .degenerate = CountIn(run, "degenerate"),
                     .failed = CountIn(run, "failed"),
                     .bad_messages = CountIn(run, "bad"),
                     .seconds = DurationIn(run, "seconds")};
    }
  } catch (const ConfigError& e) {
    throw LogError(path, e.what() + std::string("; remove its folder, and the shard is computed "
                                                "again"));
  }
  return runs;
}

}  // namespace sprout::batch
