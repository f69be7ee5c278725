#include "services/selfcalibrate/rig_watch.h"

#include <fmt/core.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <utility>

#include "common/core/image.h"
#include "common/core/quantile.h"
#include "common/inputs/check_inputs.h"
#include "services/tools/calibrate/scene/range_curve_fit.h"

namespace sprout::selfcalibrate {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;
constexpr char kRefine[] =
    "sprout-record --dir recording --seconds 10; sprout-calibrate refine recording/*.lcm --out "
    "new.textproto";

// "+0.12 ± 0.03 px", or that it is not seen.
std::string Seen(double value, double sigma, double per_unit, int digits, const char* unit) {
  if (sigma < 0) return "not seen";
  return fmt::format("{:+.{}f} ± {:.{}f} {}", per_unit * value, digits, per_unit * sigma, digits,
                     unit);
}

std::string Pixels(const SeenTurn& seen, Eigen::Index axis, double focal_px) {
  return Seen(seen.turn[axis], seen.sigma[axis], focal_px, 2, "px");
}

std::string Degrees(const SeenTurn& seen, Eigen::Index axis) {
  return Seen(seen.turn[axis], seen.sigma[axis], kDegrees, 3, "°");
}

// A remark on a turn that may be a shift of the ToF camera: both look alike, so its standard
// deviation is then large.
std::string PlaceText(const SeenTurn& tof) {
  constexpr double kSure = 3;
  const bool is_either =
      (tof.turn.array().abs() > 0 && tof.turn.array().abs() < kSure * tof.sigma.array()).any();
  return is_either ? " (turned, or moved some mm: these frames do not tell which)" : "";
}

std::string VerdictText(RigChange::Verdict verdict) {
  return verdict == RigChange::Verdict::kWrong ? "the calibration is wrong"
                                               : "the calibration is right";
}

using calibrate::RigNumber;
using calibrate::SceneRefinement;

// Matches share errors, so one in so many counts as independent, as in AdjustScene().
constexpr double kSharing = 4;

// Frames are rectified already: the rig is one of cameras without distortion, and the axes of its
// left camera are those of the left rectified frame.
calibrate::SceneRefiner RefinerFor(const Rig& rig) {
  const Rectification as_they_are{
      .left_turn = cv::Matx33d::eye(), .right_turn = cv::Matx33d::eye(), .pair = rig.pair};
  return {calibrate::RawRigOf(rig), as_they_are, calibrate::QuickEffort(rig.pair)};
}

double SigmaOf(const SceneRefinement& refined, RigNumber number) {
  constexpr double kNotShown = -1;
  return refined.wanted[number] && refined.adjusted.seen[number] ? refined.adjusted.sigma[number]
                                                                 : kNotShown;
}

SeenTurn TurnFrom(const SceneRefinement& refined, RigNumber first) {
  SeenTurn seen;
  for (size_t i = 0; i < 3; ++i) {
    const auto number = static_cast<RigNumber>(first + i);
    seen.turn[static_cast<Eigen::Index>(i)] = refined.adjusted.change[number];
    seen.sigma[static_cast<Eigen::Index>(i)] = SigmaOf(refined, number);
  }
  return seen;
}

// The change of the offset and the curve that is applied after it, as one curve.
RangeCorrection WholeCurve(const SceneRefinement& refined) {
  const double offset_m = refined.adjusted.change[calibrate::kRangeOffset];
  const double sigma_m = std::max(0.0, SigmaOf(refined, calibrate::kRangeOffset));
  RangeCorrection whole = refined.curve;
  for (CorrectionKnot& knot : whole) {
    knot.range_m -= offset_m;
    knot.offset_m += offset_m;
    knot.sigma_m = std::hypot(knot.sigma_m, sigma_m);
  }
  const double frames_sigma_m = refined.adjusted.frames_sigma[calibrate::kRangeOffset];
  if (whole.empty() && calibrate::IsSignificantCorrection(offset_m, frames_sigma_m)) {
    whole.push_back({1 / Median(std::vector(refined.adjusted.inverse_depths)), offset_m, sigma_m});
  }
  return whole;
}

std::string JoinedReasons(const SceneRefinement& refined) {
  std::string text = "no change makes the frames fit";
  for (const std::string& reason : refined.reasons) text += "; " + reason;
  return text;
}

}  // namespace

std::string ChangeText(const RigChange& change, const RectifiedPair& pair) {
  if (change.verdict == RigChange::Verdict::kUnseen) {
    return fmt::format("no calibration can be told from {} frames: {}", change.frames,
                       change.reason);
  }
  return fmt::format(
      "{} ({} frames, {} matches): rows {} (spread {:.2f} px), right camera pitch {}, yaw {}, roll "
      "{}; ToF camera pitch {}, yaw {}, roll {}{}, ranges {}",
      VerdictText(change.verdict), change.frames, change.matches,
      Seen(change.rows_px, change.rows_sigma_px, 1, 2, "px"), change.rows_spread_px,
      Pixels(change.right, 0, pair.focal_px), Pixels(change.right, 1, pair.focal_px),
      Degrees(change.right, 2), Pixels(change.tof, 0, pair.focal_px),
      Pixels(change.tof, 1, pair.focal_px), Degrees(change.tof, 2), PlaceText(change.tof),
      Seen(change.range_offset_m, change.range_sigma_m, 1000, 1, "mm"));
}

std::string AdviceText(bool applied) {
  if (applied) return "capture is asked to put it right";
  return fmt::format(
      "to put it right: {} (with --rig FILE it keeps the file's devices); or "
      "self_calibrate {{ mode: APPLY }}",
      kRefine);
}

std::string CurveText(const RangeCorrection& curve) {
  assert(!curve.empty());
  const auto most = std::ranges::max_element(
      curve, {}, [](const CorrectionKnot& knot) { return std::abs(knot.offset_m); });
  std::string knots;
  for (auto knot = curve.begin(); knot != curve.end(); ++knot) {
    if (knot != curve.begin() && knot != most && knot + 1 != curve.end()) continue;
    knots += (knots.empty() ? "" : ", ") + Seen(knot->offset_m, knot->sigma_m, 1000, 1, "mm");
    if (curve.size() > 1) knots += fmt::format(" at {:.2f} m", knot->range_m);
  }
  return fmt::format("the ToF camera's ranges lack {}: {} --rig FILE writes that into the rig file",
                     knots, kRefine);
}

TofOffsetStatus OffsetOf(const RigChange& change, const RectifiedPair& pair) {
  const double sigma = std::max(change.tof.sigma[0], change.tof.sigma[1]);
  if (std::min(change.tof.sigma[0], change.tof.sigma[1]) < 0) return {};
  // A turn about y moves points to the right, one about x upwards.
  return {.u_px = static_cast<float>(pair.focal_px * change.tof.turn[1]),
          .v_px = static_cast<float>(-pair.focal_px * change.tof.turn[0]),
          .sigma_px = static_cast<float>(pair.focal_px * sigma)};
}

RigWatch::RigWatch(const SelfCalibrateConfig& config) : config_(config) {
  RequireInRange(config, "self_calibrate");
}

Result<std::optional<RigChange>> RigWatch::Add(const Frame& frame) {
  if (!refiner_ || frame.id.rig_id != rig_id_) {
    refiner_.emplace(RefinerFor(*frame.rig));
    findings_.clear();
    rig_id_ = frame.id.rig_id;
    pair_ = frame.rig->pair;
  }
  if (const Result<void> added = refiner_->Add(frame.left, frame.right, *frame.tof); !added) {
    return tl::unexpected(added.error());
  }
  findings_.push_back(
      inputs::CheckInputs(ToGrey(frame.left), ToGrey(frame.right), {}, pair_, nullptr));
  if (refiner_->views() < config_.frames()) return std::nullopt;
  const RigChange change = Measure(frame.id);
  refiner_.reset();
  return change;
}

RigChange RigWatch::Measure(const FrameId& newest) {
  RigChange change{.newest_frame = newest, .frames = refiner_->views()};
  curve_.clear();
  const Result<SceneRefinement> refined = refiner_->Refine({});
  if (!refined) return Unseen(std::move(change), refined.error().text);
  change.matches = refined->matches;
  change.tof_matches = refined->tof_matches;
  FillRows(*refined, change);
  if (!refined->is_good()) return Unseen(std::move(change), JoinedReasons(*refined));
  FillNumbers(*refined, change);
  curve_ = WholeCurve(*refined);
  change.verdict = IsWrong(*refined) ? RigChange::Verdict::kWrong : RigChange::Verdict::kRight;
  return change;
}

RigChange RigWatch::Unseen(RigChange change, const std::string& reason) const {
  const std::string bad = inputs::BadText(inputs::Combine(findings_));
  change.reason = bad + (bad.empty() ? "" : "; ") + reason;
  return change;
}

void RigWatch::FillRows(const SceneRefinement& refined, RigChange& change) const {
  std::vector<double> rows;
  for (const calibrate::ShownMatch& match : refined.shown) rows.push_back(match.rows_before_px);
  const double median = Median(rows);
  for (double& row : rows) row = std::abs(row - median);
  const auto count = static_cast<double>(rows.size());
  const double spread = 1.4826 * Median(std::move(rows));
  // The standard deviation of a median of Gaussian errors is 1.2533 times that of their mean.
  constexpr double kMedianOverMean = 1.2533;
  change.rows_px = static_cast<float>(median);
  change.rows_spread_px = static_cast<float>(spread);
  change.rows_sigma_px = static_cast<float>(kMedianOverMean * spread * std::sqrt(kSharing / count));
}

void RigWatch::FillNumbers(const SceneRefinement& refined, RigChange& change) const {
  change.right = TurnFrom(refined, calibrate::kPitch);
  change.tof = TurnFrom(refined, calibrate::kTofPitch);
  change.range_offset_m = refined.adjusted.change[calibrate::kRangeOffset];
  change.range_sigma_m = SigmaOf(refined, calibrate::kRangeOffset);
}

bool RigWatch::IsWrong(const SceneRefinement& refined) const {
  const calibrate::RigNumbers& numbers = refined.adjusted.change;
  const calibrate::MovedPx moved = calibrate::MaxMoved(numbers, pair_);
  const double per_m = Median(std::vector(refined.adjusted.inverse_depths));
  const double range_px = pair_.focal_px * pair_.baseline_m * per_m * per_m *
                          std::abs(numbers[calibrate::kRangeOffset]);
  return moved.right > config_.least_px() || std::max(moved.tof, range_px) > config_.least_tof_px();
}

}  // namespace sprout::selfcalibrate
