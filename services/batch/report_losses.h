#ifndef SPROUT_SERVICES_BATCH_REPORT_LOSSES_H_
#define SPROUT_SERVICES_BATCH_REPORT_LOSSES_H_

#include <cstddef>
#include <string>

#include "services/batch/losses.h"

namespace sprout::batch {

/// Rows of a table of the report that has one a log; how many more there are is said below it.
inline constexpr size_t kShownLogs = 200;

/// Section of the report: shards that failed or were tried again, frames that are missing or bad,
/// in total and for each log that has some, and why shards failed. @throws LogError.
std::string LossesHtml(const BatchFolder& folder, const Manifest& manifest,
                       const BatchState& state);

}  // namespace sprout::batch

#endif  // SPROUT_SERVICES_BATCH_REPORT_LOSSES_H_
