#include "services/calibrate/check.h"

#include <algorithm>
#include <iostream>
#include <optional>
#include <stdexcept>

#include "common/app/progress.h"
#include "common/bus/channels.h"
#include "common/rig/rectifier.h"
#include "common/rig/rig_file.h"
#include "services/calibrate/frame_log.h"
#include "services/calibrate/rectify_images.h"
#include "services/calibrate/rig_checker.h"

namespace sprout::calibrate {
namespace {

// So many frames, evenly over the log, tell what all of them do.
constexpr int64_t kCheckedFrames = 30;

Result<void> AddRectified(const Rectifier& rectifier, const Frame& frame, RigChecker& checker) {
  const Result<RigImages> images =
      RectifyImages(rectifier, {.left = frame.left, .right = frame.right, .tof = *frame.tof});
  if (!images) return tl::unexpected(images.error());
  return checker.Add(images->left, images->right, images->tof, rectifier.rig());
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
  const int64_t frames = CountMessages(options.log, prefix + std::string(ChannelOf(Part::kLeft)));
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
  if (check.reasons.empty()) return 0;
  std::cout << "to put it right without a board: sprout-calibrate refine " << options.log.string()
            << " --rig " << (options.rig.empty() ? "rig.textproto" : options.rig.string())
            << " --out new.textproto\n";
  return 1;
}

}  // namespace sprout::calibrate
