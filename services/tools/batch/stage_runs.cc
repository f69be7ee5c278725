#include "services/tools/batch/stage_runs.h"

#include <cinttypes>
#include <cmath>
#include <cstdio>

#include "common/core/read_text.h"
#include "common/logfile/log_error.h"
#include "services/tools/batch/log_task.h"

namespace sprout::batch {

std::optional<StageRun> ParseReplayReport(const std::string& output) {
  const size_t at = output.find(" events; frames: ");
  int64_t in = 0, out = 0, degenerate = 0, failed = 0, incomplete = 0, left_out = 0, bad = 0,
          damaged = 0;
  if (at == std::string::npos ||
      std::sscanf(output.c_str() + at,
                  " events; frames: %" SCNd64 " in, %" SCNd64 " out (%" SCNd64
                  " degenerate), %" SCNd64 " failed, %" SCNd64 " incomplete, %" SCNd64
                  " left out; %" SCNd64 " bad messages, %" SCNd64 " damaged bytes",
                  &in, &out, &degenerate, &failed, &incomplete, &left_out, &bad, &damaged) != 8) {
    return std::nullopt;
  }
  StageRun run;
  run.set_frames_in(in);
  run.set_frames_out(out);
  run.set_degenerate(degenerate);
  run.set_failed(failed);
  run.set_incomplete(incomplete);
  run.set_left_out(left_out);
  run.set_bad_messages(bad);
  run.set_damaged_bytes(damaged);
  return run;
}

StageRuns ReadStageRuns(const std::filesystem::path& result, const Manifest& manifest) {
  const std::filesystem::path path = result / kRuns;
  constexpr char kCure[] = "; remove its folder, and the log is computed again";
  StageRuns runs;
  const Result<std::string> text = ReadText(path);
  if (!text) throw LogError(path, text.error().text + kCure);
  try {
    ParseText(*text, "counts", runs);
  } catch (const ConfigError& e) {
    throw LogError(path, e.what() + std::string(kCure));
  }
  if (runs.run_size() != manifest.stage_size()) {
    throw LogError(path, "lacks the counts of a stage" + std::string(kCure));
  }
  for (const StageRun& run : runs.run()) {
    if (run.frames_in() >= 0 && run.frames_out() >= 0 && std::isfinite(run.seconds())) continue;
    throw LogError(path, "has a count that is not possible" + std::string(kCure));
  }
  return runs;
}

}  // namespace sprout::batch
