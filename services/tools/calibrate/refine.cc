#include "services/tools/calibrate/refine.h"

#include <fmt/core.h>

#include <algorithm>
#include <iostream>
#include <optional>
#include <stdexcept>

#include "common/app/output_paths.h"
#include "common/app/progress.h"
#include "common/bus/channels.h"
#include "common/config/config_error.h"
#include "common/core/printable.h"
#include "common/inputs/check_inputs.h"
#include "common/rig/rectifier.h"
#include "services/tools/calibrate/frame_log.h"
#include "services/tools/calibrate/image_folder.h"
#include "services/tools/calibrate/report.h"
#include "services/tools/calibrate/result_file.h"
#include "services/tools/calibrate/scene/rig_change.h"
#include "services/tools/calibrate/scene/scene_checks.h"
#include "services/tools/calibrate/scene/scene_refiner.h"

namespace sprout::calibrate {
namespace {

namespace fs = std::filesystem;

// Reads all inputs into one refiner.
class Reader {
 public:
  enum class Purpose { kRefine, kCheck };

  Reader(const RefineOptions& options, Purpose purpose)
      : options_(options), finds_(purpose == Purpose::kCheck) {
    if (options.rig.empty()) return;
    description_ = LoadRigFile(options.rig);
    const RawRig raw = RequireCalibration(description_, options.rig);
    rectifier_.emplace(raw);
    if (const std::string warning = ViewsWarning(rectifier_->views()); !warning.empty()) {
      std::cerr << "sprout-calibrate: " << warning << "\n";
    }
    Start(raw, RectificationOf(raw));
  }

  SceneRefiner& Read() {
    const auto inputs = static_cast<int64_t>(options_.inputs.size());
    max_of_input_ = std::max<int64_t>(1, SceneRefiner::kMaxViews / inputs);
    for (const fs::path& input : options_.inputs) {
      if (fs::is_directory(input)) {
        ReadFolder(input);
      } else if (const std::string raw = Channel(kRawPrefix, Part::kLeft);
                 const int64_t frames = CountMessages(input, raw)) {
        RequireRig(input, "its images are not rectified");
        ReadRawLog(input, frames);
      } else {
        ReadLog(input);
      }
    }
    progress_.Clear();
    if (used_ == 0) throw std::runtime_error("no frame can be used: " + refusal_);
    return *refiner_;
  }

  const RigDescription& description() const { return description_; }

  /// Findings about the inputs, of all frames that were used together.
  inputs::Findings FindingsOfAll() const { return inputs::Combine(findings_); }

 private:
  void Start(const RawRig& rig, const Rectification& images) {
    refiner_.emplace(rig, images, finds_ ? QuickEffort(images.pair) : SceneEffort());
  }

  std::string Channel(std::string_view kind, Part part) const {
    return options_.prefix + std::string(kind) + std::string(ChannelOf(part));
  }

  void RequireRig(const fs::path& input, const char* why) const {
    if (!rectifier_) throw ConfigError(input.string() + ": " + why + ": --rig is needed");
  }

  // Adds a frame if it is one of those that are chosen evenly over an input.
  template <typename Add>
  void Choose(int64_t index, int64_t count, const fs::path& input, const Add& add) {
    const int64_t used = std::min(count, max_of_input_);
    if (index * used / count == (index + 1) * used / count) return;
    progress_.ShowTime(input.string() + ": frame " + std::to_string(index + 1) + " of " +
                       std::to_string(count));
    if (const Result<void> added = add(); added) {
      ++used_;
    } else {
      refusal_ = added.error().text;
    }
  }

  Result<void> AddRaw(const RigImages& raw) {
    const Result<RigImages> images = RectifyImages(*rectifier_, raw);
    if (!images) return tl::unexpected(images.error());
    return Add(*images);
  }

  Result<void> Add(const RigImages& images) {
    const Result<void> added = refiner_->Add(images.left, images.right, images.tof);
    if (added && finds_) {
      findings_.push_back(
          inputs::CheckInputs(images.left, images.right, images.tof, refiner_->RigBefore()));
    }
    return added;
  }

  void ReadFolder(const fs::path& folder) {
    RequireRig(folder, "images of a folder are not rectified");
    int64_t count = 0;
    ReadImageFolder(folder, options_.bits, [&](const RigImages&) { ++count; });
    int64_t index = 0;
    const auto notes = ReadImageFolder(folder, options_.bits, [&](const RigImages& images) {
      Choose(index++, count, folder, [&] { return AddRaw(images); });
    });
    for (const std::string& note : notes) std::cerr << "sprout-calibrate: " << note << "\n";
  }

  void ReadRawLog(const fs::path& log, int64_t count) {
    int64_t index = 0;
    Complain(ReadFrameLog(log, options_.prefix + std::string(kRawPrefix),
                          {Part::kLeft, Part::kRight, Part::kTof}, [&](const Frame& frame) {
                            Choose(index++, count, log, [&] {
                              return AddRaw({frame.left, frame.right, *frame.tof});
                            });
                          }));
  }

  void ReadLog(const fs::path& log) {
    const int64_t count = std::max<int64_t>(1, CountMessages(log, Channel("", Part::kLeft)));
    int64_t index = 0;
    Complain(ReadFrameLog(log, options_.prefix, {Part::kLeft, Part::kRight, Part::kTof, Part::kRig},
                          [&](const Frame& frame) {
                            Choose(index++, count, log, [&] { return AddRectified(frame, log); });
                          }));
  }

  Result<void> AddRectified(const Frame& frame, const fs::path& log) {
    const std::string rig_id = RigId(*frame.rig);
    if (!rig_id_) {
      if (rectifier_ && RigId(rectifier_->rig()) != rig_id) {
        throw ConfigError(log.string() + ": was rectified with calibration " + rig_id + ", but " +
                          options_.rig.string() + " is " + RigId(rectifier_->rig()) +
                          ": allowed is the rig file with which it was recorded");
      }
      if (!rectifier_) {
        Start(RawRigOf(*frame.rig), {.left_turn = cv::Matx33d::eye(),
                                     .right_turn = cv::Matx33d::eye(),
                                     .pair = frame.rig->pair});
      }
      rig_id_ = rig_id;
    }
    if (*rig_id_ != rig_id) {
      return Fail("a frame of another calibration, " + rig_id + " instead of " + *rig_id_);
    }
    return Add({frame.left, frame.right, *frame.tof});
  }

  void Complain(const std::string& complaint) {
    if (complaint.empty()) return;
    progress_.Clear();
    std::cerr << "sprout-calibrate: " << complaint << "\n";
  }

  const RefineOptions& options_;
  bool finds_;                              // whether inputs are checked for findings
  std::vector<inputs::Findings> findings_;  // of each frame
  RigDescription description_;
  std::optional<Rectifier> rectifier_;  // with --rig
  std::optional<SceneRefiner> refiner_;
  std::optional<std::string> rig_id_;  // of the rectified frames so far
  Progress progress_{/*quiet=*/false};
  int64_t max_of_input_ = 1;
  int64_t used_ = 0;
  std::string refusal_ = "there is none";
};

// The command that refines what was checked. Without a rig file it takes the calibration in the
// log.
std::string RefineCommand(const RefineOptions& options) {
  std::string command = "sprout-calibrate refine";
  for (const fs::path& input : options.inputs) command += " " + ShellWord(input.string());
  if (!options.rig.empty()) command += " --rig " + ShellWord(options.rig.string());
  if (!options.prefix.empty()) command += " --channel-prefix " + ShellWord(options.prefix);
  if (options.bits != 0) command += fmt::format(" --bits {}", options.bits);
  return command + " --out new.textproto";
}

// The bad findings about the inputs, for the report when there is no refinement.
std::vector<std::string> BadOf(const inputs::Findings& findings) {
  std::vector<std::string> bad;
  for (const inputs::Finding& finding : findings) {
    if (finding.verdict == inputs::Verdict::kBad) bad.push_back(finding.text);
  }
  return bad;
}

}  // namespace

int RunRefine(const RefineOptions& options) {
  const auto wished = [&](const char* name) {
    return std::ranges::find(options.also, name) != options.also.end();
  };
  RequireResultFiles(options.inputs, options.rig, options.out, options.report);
  Reader reader(options, Reader::Purpose::kRefine);
  SceneRefiner& refiner = reader.Read();
  Progress progress(/*quiet=*/false);
  progress.ShowTime("fitting");
  const Result<SceneRefinement> refined = refiner.Refine({.focal = wished("focal"),
                                                          .row = wished("row"),
                                                          .place = wished("place"),
                                                          .yaw = wished("yaw")});
  progress.Clear();
  if (!refined) throw std::runtime_error(refined.error().text);

  RigDescription rig = reader.description();
  // The limits of self-calibration count from the board's calibration.
  if (rig.has_calibration() && !rig.has_board_calibration()) {
    *rig.mutable_board_calibration() = rig.calibration();
  }
  *rig.mutable_calibration() = ToCalibration(refined->rig);
  if (!options.report.empty()) WriteWhole(options.report, SceneReportHtml(*refined, refiner));
  std::cout << SceneSummaryText(*refined);
  SaveResult(rig, refined->is_good(), options.out);
  return refined->is_good() ? 0 : 1;
}

int RunCheck(const RefineOptions& options) {
  Reader reader(options, Reader::Purpose::kCheck);
  SceneRefiner& refiner = reader.Read();
  const Result<SceneRefinement> refined = refiner.Refine({});
  const inputs::Findings findings = reader.FindingsOfAll();
  const RectifiedPair pair = refiner.RigBefore().pair;
  std::vector<std::string> reasons =
      refined ? ReasonsToCalibrate(*refined, findings, pair) : BadOf(findings);
  const bool is_wrong = !reasons.empty();
  // What no calibration puts right: images that are blank, or not of one scene or moment, and so
  // on.
  using enum inputs::Question;
  const bool are_useless =
      AnyIsBad(findings, {kScene, kTime, kSides, kBits, kContrast, kHits, kMoment});
  const bool cannot_tell = !is_wrong && !(refined && refined->is_good());
  if (!refined) {
    reasons.push_back(refined.error().text);
  } else if (cannot_tell) {
    reasons = refined->reasons;
  }
  std::cout << fmt::format("{} frames: {}\n", refiner.views(),
                           are_useless   ? "cannot tell: the images are wrong"
                           : is_wrong    ? "has to be calibrated again"
                           : cannot_tell ? "cannot tell"
                                         : "good");
  for (const std::string& reason : reasons) std::cout << "  * " << reason << "\n";
  if (refined) std::cout << SceneCheckText(*refined, pair);
  for (const inputs::Finding& finding : findings) {
    std::cout << fmt::format("{:<30} {}: {}\n", inputs::NameOf(finding.question),
                             inputs::NameOf(finding.verdict), finding.text);
  }
  if (is_wrong && refined && !are_useless) {
    std::cout << "to put it right without a board: " << RefineCommand(options) << "\n";
  }
  return reasons.empty() ? 0 : 1;
}

}  // namespace sprout::calibrate
