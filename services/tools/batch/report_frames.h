#ifndef SPROUT_SERVICES_TOOLS_BATCH_REPORT_FRAMES_H_
#define SPROUT_SERVICES_TOOLS_BATCH_REPORT_FRAMES_H_

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "services/tools/batch/frame_lookup.h"
#include "services/tools/batch/frame_table.h"

namespace sprout::batch {

/// Lines for a shell that show a frame of a log in sprout-view, and that compute it again with each
/// variant. Names are quoted, whatever they contain.
/// @param programs  folder of sprout-view.
std::string FrameCommands(const BatchFolder& folder, const Manifest& manifest, const BatchLog& log,
                          int64_t seq, const std::filesystem::path& programs);

/// Single frames in the report.
class ReportFrames {
 public:
  /// @param programs  as above.
  ReportFrames(const BatchFolder& folder, const Manifest& manifest, const FrameTable& frames,
               std::filesystem::path programs)
      : folder_(folder), manifest_(manifest), frames_(frames), programs_(std::move(programs)) {}

  /// Those with the highest or lowest values in a column, the most extreme first, with pictures and
  /// commands; empty if there are none.
  std::string Html(const std::string& title, const std::string& column, bool lowest);

 private:
  std::string OneHtml(size_t row);
  std::string PicturesHtml(size_t row);
  FrameLookup& AnswersOf(int log, int variant);
  cv::Mat LeftOf(size_t row) const;

  const BatchFolder& folder_;
  const Manifest& manifest_;
  const FrameTable& frames_;
  std::filesystem::path programs_;
  std::map<std::pair<int, int>, std::unique_ptr<FrameLookup>> answers_;  // log, variant
};

}  // namespace sprout::batch

#endif  // SPROUT_SERVICES_TOOLS_BATCH_REPORT_FRAMES_H_
