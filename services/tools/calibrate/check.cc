#include "services/tools/calibrate/check.h"

#include <algorithm>
#include <iostream>
#include <optional>
#include <stdexcept>

#include "common/app/progress.h"
#include "common/bus/channels.h"
#include "common/config/config_error.h"
#include "common/core/shell_word.h"
#include "common/rig/rectifier.h"
#include "common/rig/rig_file.h"
#include "services/tools/calibrate/frame_log.h"
#include "services/tools/calibrate/image_folder.h"
#include "services/tools/calibrate/rectify_images.h"
#include "services/tools/calibrate/rig_checker.h"

namespace sprout::calibrate {
namespace {

namespace fs = std::filesystem;

// So many frames, evenly over the log, tell what all of them do.
constexpr int64_t kCheckedFrames = 30;

// Reads what is to be checked into a checker.
class CheckReader {
 public:
  explicit CheckReader(const CheckOptions& options) : options_(options) {
    if (options.rig.empty()) return;
    rectifier_.emplace(RequireCalibration(LoadRigFile(options.rig), options.rig));
    const std::string warning = ViewsWarning(rectifier_->views());
    if (!warning.empty()) std::cerr << "sprout-calibrate: " << warning << "\n";
  }

  RigCheck Check() {
    fs::is_directory(options_.input) ? ReadFolder() : ReadLog();
    progress_.Clear();
    const RigCheck check = checker_.Summary();
    if (check.frames == 0) throw std::runtime_error("no frame can be checked: " + refusal_);
    return check;
  }

 private:
  void ReadFolder() {
    if (!rectifier_) {
      throw ConfigError(options_.input.string() +
                        ": images of a folder are not rectified: --rig is needed");
    }
    int64_t count = 0;
    constexpr int kFoundOut = 0;  // how many bits images use
    ReadImageFolder(options_.input, kFoundOut, [&](const RigImages&) { ++count; });
    stride_ = std::max<int64_t>(1, count / kCheckedFrames);
    const auto notes = ReadImageFolder(options_.input, kFoundOut, [&](const RigImages& images) {
      Offer(count, [&] { return AddRaw(images); });
    });
    progress_.Clear();
    for (const std::string& note : notes) std::cerr << "sprout-calibrate: " << note << "\n";
  }

  void ReadLog() {
    const std::string prefix =
        options_.prefix + (rectifier_ ? std::string(kRawPrefix) : std::string());
    PartSet parts = {Part::kLeft, Part::kRight, Part::kTof};
    if (!rectifier_) parts.Add(Part::kRig);
    const int64_t count =
        CountMessages(options_.input, prefix + std::string(ChannelOf(Part::kLeft)));
    stride_ = std::max<int64_t>(1, count / kCheckedFrames);
    const std::string complaint =
        ReadFrameLog(options_.input, prefix, parts, [&](const Frame& frame) {
          Offer(count, [&] {
            return rectifier_ ? AddRaw({frame.left, frame.right, *frame.tof})
                              : checker_.Add(frame.left, frame.right, *frame.tof, *frame.rig);
          });
        });
    progress_.Clear();
    if (!complaint.empty()) std::cerr << "sprout-calibrate: " << complaint << "\n";
  }

  // Every stride-th is added.
  template <typename Add>
  void Offer(int64_t count, const Add& add) {
    if (next_++ % stride_ != 0) return;
    progress_.ShowTime("checking frame " + std::to_string(next_) + " of " + std::to_string(count));
    if (const Result<void> added = add(); !added) refusal_ = added.error().text;
  }

  Result<void> AddRaw(const RigImages& raw) {
    const Result<RigImages> images = RectifyImages(*rectifier_, raw);
    if (!images) return tl::unexpected(images.error());
    return checker_.Add(images->left, images->right, images->tof, rectifier_->rig());
  }

  const CheckOptions& options_;
  std::optional<Rectifier> rectifier_;
  RigChecker checker_;
  Progress progress_{/*quiet=*/false};
  std::string refusal_;
  int64_t stride_ = 1;
  int64_t next_ = 0;
};

// The command that refines the rig. Without a rig file it takes the calibration in the log.
std::string RefineCommand(const CheckOptions& options) {
  std::string command = "sprout-calibrate refine " + ShellWord(options.input.string());
  if (!options.rig.empty()) command += " --rig " + ShellWord(options.rig.string());
  if (!options.prefix.empty()) command += " --channel-prefix " + ShellWord(options.prefix);
  return command + " --out new.textproto";
}

}  // namespace

int RunCheck(const CheckOptions& options) {
  const RigCheck check = CheckReader(options).Check();
  std::cout << CheckText(check);
  if (check.reasons.empty()) return 0;
  std::cout << "to put it right without a board: " << RefineCommand(options) << "\n";
  return 1;
}

}  // namespace sprout::calibrate
