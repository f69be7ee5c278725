#ifndef SPROUT_SERVICES_TOOLS_BATCH_REPORT_H_
#define SPROUT_SERVICES_TOOLS_BATCH_REPORT_H_

#include <string>

#include "services/tools/batch/frame_table.h"

namespace sprout::batch {

/// Rows of a table of the report that has one a log; how many more there are is said below it.
inline constexpr size_t kShownLogs = 200;

/// Writes report.html: one page that works offline. It shows what changed, what failed or is
/// missing, in which logs; distributions; the most changed and the worst frames with pictures, each
/// with the commands to show it and to compute it again.
/// @param program  path of sprout-batch; its folder has the programs that the commands name.
/// O(frames); pictures of some 20 frames are read from logs and results. @throws LogError.
void WriteReport(const BatchFolder& folder, const Manifest& manifest, const BatchState& state,
                 const FrameTable& frames, const std::string& program);

/// Section of the report: logs that failed or were tried again, frames that are missing or bad, in
/// total and for each log that has some, and why logs failed. @throws LogError.
std::string LossesHtml(const BatchFolder& folder, const Manifest& manifest,
                       const BatchState& state);

/// Tables of the report: the mean of each measure, and the logs with a strip along each.
std::string MeansHtml(const Manifest& manifest, const FrameTable& frames);
std::string LogsHtml(const Manifest& manifest, const FrameTable& frames);

/// The columns of frames.csv, without "a_" and "b_", that the report shows.
std::vector<std::string> ShownMeasures(const Manifest& manifest);

}  // namespace sprout::batch

#endif  // SPROUT_SERVICES_TOOLS_BATCH_REPORT_H_
