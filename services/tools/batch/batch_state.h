#ifndef SPROUT_SERVICES_TOOLS_BATCH_BATCH_STATE_H_
#define SPROUT_SERVICES_TOOLS_BATCH_BATCH_STATE_H_

#include <vector>

#include "services/tools/batch/manifest.h"

namespace sprout::batch {

/// Progress of a batch.
struct BatchState {
  std::vector<bool> done;  ///< by log
  int missing = 0;
};

/// Checks of every log whether its results exist and have their full sizes. O(logs).
BatchState StateOf(const BatchFolder& folder, const Manifest& manifest);

/// The same, and links logs/NAME_a.lcm and NAME_b.lcm to the answers of the logs that are done.
/// Answers that have no link yet are read for their digests: damaged ones do not count as done, and
/// lose their list of files, so that they are computed again; one line on stderr each.
/// @throws Interrupted; std::filesystem::filesystem_error when a link cannot be made.
BatchState LinkAnswers(const BatchFolder& folder, const Manifest& manifest);

/// Removes what killed processes left: folders that were not renamed yet.
void RemoveParts(const BatchFolder& folder);

}  // namespace sprout::batch

#endif  // SPROUT_SERVICES_TOOLS_BATCH_BATCH_STATE_H_
