#include "services/calibrate/check.h"

#include <algorithm>
#include <iostream>
#include <optional>
#include <stdexcept>

#include "common/app/progress.h"
#include "common/bus/channels.h"
#include "common/core/image.h"
#include "common/logfile/log_reader.h"
#include "common/rig/rectifier.h"
#include "common/rig/rig_file.h"
#include "services/calibrate/frame_log.h"
#include "services/calibrate/rig_checker.h"

namespace sprout::calibrate {
namespace {

// So many frames, evenly over the log, tell what all of them do.
constexpr int64_t kCheckedFrames = 30;

int64_t CountEvents(const std::filesystem::path& path, const std::string& channel) {
  LogReader reader(path);
  int64_t count = 0;
  for (LogEvent event; reader.Next(event);) count += event.channel == channel ? 1 : 0;
  return count;
}

Result<void> AddRectified(const Rectifier& rectifier, const Frame& frame, RigChecker& checker) {
  const cv::Size size = rectifier.raw().left.size();
  if (frame.left.size() != size || frame.right.size() != size) {
    return Fail("images of " + SizeText(frame.left.size()) + " and " +
                SizeText(frame.right.size()) + ": allowed is the calibrated size " +
                SizeText(size));
  }
  TofImage tof = *frame.tof;
  if (const auto fits = CheckTofSize(RigOfFrame(rectifier.rig(), tof), tof); !fits) return fits;
  tof.depth_m = tof.depth_m.clone();
  if (!tof.depth_m.empty()) rectifier.CorrectRanges(tof);
  return checker.Add(rectifier.RectifyLeft(frame.left), rectifier.RectifyRight(frame.right), tof,
                     rectifier.rig());
}

}  // namespace

int RunCheck(const CheckOptions& options) {
  std::optional<Rectifier> rectifier;
  std::string prefix = options.prefix;
  PartSet parts = {Part::kLeft, Part::kRight, Part::kTof};
  if (options.rig.empty()) {
    parts.Add(Part::kRig);
  } else {
    rectifier.emplace(RequireCalibration(LoadRigFile(options.rig), options.rig));
    const std::string warning = ViewsWarning(rectifier->views());
    if (!warning.empty()) std::cerr << "sprout-calibrate: " << warning << "\n";
    prefix += kRawPrefix;
  }
  const int64_t frames = CountEvents(options.log, prefix + std::string(ChannelOf(Part::kLeft)));
  const int64_t stride = std::max<int64_t>(1, frames / kCheckedFrames);
  RigChecker checker;
  Progress progress(/*quiet=*/false);
  std::string refusal;
  int64_t next = 0;
  const std::string complaint = ReadFrameLog(options.log, prefix, parts, [&](const Frame& frame) {
    if (next++ % stride != 0) return;
    progress.Show("checking frame " + std::to_string(frame.id.seq));
    const Result<void> added = rectifier
                                   ? AddRectified(*rectifier, frame, checker)
                                   : checker.Add(frame.left, frame.right, *frame.tof, *frame.rig);
    if (!added) refusal = added.error().text;
  });
  progress.Clear();
  if (!complaint.empty()) std::cerr << "sprout-calibrate: " << complaint << "\n";
  const RigCheck check = checker.Summary();
  if (check.frames == 0) throw std::runtime_error("no frame can be checked: " + refusal);
  std::cout << CheckText(check);
  return check.reasons.empty() ? 0 : 1;
}

}  // namespace sprout::calibrate
