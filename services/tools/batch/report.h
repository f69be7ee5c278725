#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "services/tools/batch/frame_table.h"
#include "services/tools/batch/measures.h"

namespace sprout::batch {

/// Most rows of a table of the report that has a row for each log.
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

  /// The frames with the highest or lowest values in a column, the most extreme first, with
  /// pictures and commands; empty if there are none.
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
