#ifndef SPROUT_SERVICES_BATCH_REPORT_H_
#define SPROUT_SERVICES_BATCH_REPORT_H_

#include <string>

#include "services/batch/merge.h"

namespace sprout::batch {

/// Writes report.html from frames.csv and the results: one page that works offline. It shows what
/// changed, in which logs; distributions; the most changed and the worst frames with pictures, each
/// with the commands to show it and to compute it again.
/// @param program  path of sprout-batch; its folder has the programs that the commands name.
/// O(frames); pictures of some 20 frames are read from the results. @throws LogError.
void WriteReport(const BatchFolder& folder, const Manifest& manifest, const BatchState& state,
                 const std::string& program);

}  // namespace sprout::batch

#endif  // SPROUT_SERVICES_BATCH_REPORT_H_
