#ifndef SPROUT_SERVICES_TOOLS_BATCH_ANSWERS_H_
#define SPROUT_SERVICES_TOOLS_BATCH_ANSWERS_H_

#include <filesystem>
#include <string>
#include <vector>

#include "services/tools/batch/manifest.h"
#include "services/tools/batch/table.h"

namespace sprout::batch {

/// Writes one log of several, as `sprout-log merge` does: by time; each log keeps its order, of
/// equal times the one named first comes first. @throws LogError.
void MergeLogs(const std::vector<std::string>& logs, const std::filesystem::path& out);

/// Measures what the stages of a batch answered, see MeasureFrames().
/// @param logs  the input, and what each stage answered. @throws LogError.
Table MeasureAnswers(const Manifest& manifest, const SproutConfig& config,
                     const std::vector<std::string>& logs);

/// Whether no frame of the log has all that the first stage needs; then counts why. Reads the whole
/// log. @throws LogError.
bool CountWithoutFrames(const Manifest& manifest, const BatchLog& log, const SproutConfig& config,
                        StageRun& run);

}  // namespace sprout::batch

#endif  // SPROUT_SERVICES_TOOLS_BATCH_ANSWERS_H_
