#include "services/capture/rig_keeper.h"

#include <fmt/core.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <utility>

#include "common/app/output_paths.h"
#include "common/config/required.h"
#include "common/core/checks.h"
#include "common/core/digest.h"
#include "common/core/result.h"
#include "common/rig/rectifier.h"
#include "common/rig/rig.pb.h"

namespace sprout::capture {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;

double DegreesBetween(const Pose& a, const Pose& b) {
  return kDegrees * Eigen::Quaterniond(a.rotation).angularDistance(Eigen::Quaterniond(b.rotation));
}

// A rig with a change that was seen in its rectified images. Numbers that are 0 in it stay.
// @param made  how these images were rectified: RectificationOf(rig).
RawRig ChangedRig(const RawRig& rig, const Rectification& made, const RigChange& change) {
  const Eigen::Matrix3d left_from_rectified = BackOf(made.left_turn);
  RawRig changed = rig;
  changed.left_from_right = TurnedBy(rig.left_from_right, left_from_rectified * change.right.turn);
  if (rig.tof.width == 0) return changed;
  changed.left_from_tof = TurnedBy(rig.left_from_tof, left_from_rectified * change.tof.turn);
  changed.range_offset_m += change.range_offset_m;
  return changed;
}

// Whether a rig is within the limits from the board's calibration; the error names the number that
// is not, and what to do.
Result<void> CheckLimits(const RawRig& rig, const RawRig& board,
                         const SelfCalibrationLimits& limits) {
  constexpr double kMm = 1000;
  constexpr const char* kAdvice =
      "from the board's calibration (self_calibration of the rig file); "
      "beyond: calibrate with the board";
  const auto within = [&](Checks& checks, const char* what, double value, double most,
                          const char* unit) {
    checks.Within(what, value, 0, most, (std::string(unit) + " " + kAdvice).c_str());
  };
  Checks checks;
  within(checks, "turn of the right camera",
         DegreesBetween(rig.left_from_right, board.left_from_right), limits.turn_deg(), "degrees");
  within(checks, "turn of the ToF camera", DegreesBetween(rig.left_from_tof, board.left_from_tof),
         limits.tof_turn_deg(), "degrees");
  within(checks, "change of the ranges", kMm * std::abs(rig.range_offset_m - board.range_offset_m),
         limits.range_mm(), "mm");
  if (!checks.ok()) return checks.error();
  return {};
}

// Name of a changed calibration. Unlike RigId() it differs also when only the ranges change.
std::string ChangedRigId(const RigDescription& file) {
  return Digest(ConfigText(file.calibration()));
}

std::string TurnText(const char* what, const SeenTurn& seen) {
  if (seen.turn.isZero(0)) return "";
  const Eigen::Vector3d turn = kDegrees * seen.turn;
  return fmt::format("{}pitch {:+.3f}°, yaw {:+.3f}°, roll {:+.3f}°", what, turn[0], turn[1],
                     turn[2]);
}

// "right camera pitch +0.230°, yaw +0.000°, roll +0.000°; ranges +12.0 mm"
std::string TextOf(const RigChange& change) {
  std::string text = TurnText("right camera ", change.right);
  const auto add = [&](const std::string& more) {
    if (!more.empty()) text += (text.empty() ? "" : "; ") + more;
  };
  add(TurnText("ToF camera ", change.tof));
  if (change.range_offset_m != 0) {
    add(fmt::format("ranges {:+.1f} mm", 1000 * change.range_offset_m));
  }
  return text;
}

RawRig BoardOf(const CurrentRig& rig) {
  try {
    return *BoardCalibrationOf(rig.file());
  } catch (const ConfigError& e) {
    throw ConfigError("rig file " + rig.path().string() + ": " + e.what());
  }
}

}  // namespace

RigKeeper::RigKeeper(const SelfCalibrateConfig& config, std::shared_ptr<CurrentRig> current)
    : config_(config), current_(std::move(current)), board_(BoardOf(*current_)) {
  if (config_.folder().empty()) {
    throw ConfigError(
        "self_calibrate.folder is empty: with self_calibrate.mode = APPLY allowed is a folder for "
        "the calibrations");
  }
  const std::filesystem::path first = FileOf(current_->Get()->rig_id);
  RequireWritableFolder("self_calibrate.folder", config_.folder(), {first.filename().c_str()});
  Required(SaveRigFile(first, current_->file()), "self_calibrate.folder: ");
}

RigKeeper::Outcome RigKeeper::Consider(const RigChange& change, Clock::time_point now) {
  const RigInUsePtr used = current_->Get();
  if (change.verdict != RigChange::Verdict::kWrong || now < next_ ||
      change.newest_frame.rig_id != used->rig_id) {
    return {};
  }
  const bool is_none =
      change.right.turn.isZero(0) && change.tof.turn.isZero(0) && change.range_offset_m == 0;
  if (is_none) return {.text = "the calibration is not changed: the change is 0"};
  const RawRig& raw = used->rectifier.raw();
  const RawRig changed = ChangedRig(raw, RectificationOf(raw), change);
  Result<void> usable = CheckRawRig(changed);
  if (usable) usable = CheckLimits(changed, board_, current_->file().self_calibration());
  if (!usable) return {.text = "the calibration is not changed: " + usable.error().text};

  const RigDescription file = Changed(changed);
  const std::string rig_id = ChangedRigId(file);
  const std::filesystem::path path = FileOf(rig_id);
  if (const Result<void> saved = SaveRigFile(path, file); !saved) {
    return {.text = "the calibration is not changed: " + saved.error().text};
  }
  current_->Replace(std::make_shared<const RigInUse>(RigInUse{Rectifier(changed), rig_id}));
  next_ = now + std::chrono::duration_cast<Clock::duration>(
                    std::chrono::duration<double>(config_.pause_s()));
  return {.used = true,
          .text = fmt::format("the calibration was put right by {}: {} instead of {}, in {}",
                              TextOf(change), rig_id, used->rig_id, path.string())};
}

RigDescription RigKeeper::Changed(const RawRig& rig) const {
  RigDescription file = current_->file();
  if (!file.has_board_calibration()) *file.mutable_board_calibration() = file.calibration();
  *file.mutable_calibration() = ToCalibration(rig);
  return file;
}

std::filesystem::path RigKeeper::FileOf(const std::string& rig_id) const {
  return std::filesystem::path(config_.folder()) / ("rig_" + rig_id + ".textproto");
}

}  // namespace sprout::capture
