#include "services/selfcalibrate/change_text.h"

#include <fmt/core.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

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

std::string VerdictText(RigChange::Verdict verdict) {
  return verdict == RigChange::Verdict::kWrong ? "the calibration is wrong"
                                               : "the calibration is right";
}

}  // namespace

std::string ChangeText(const RigChange& change, const RectifiedPair& pair) {
  if (change.verdict == RigChange::Verdict::kUnseen) {
    return fmt::format("no calibration can be told from {} frames: {}", change.frames,
                       change.reason);
  }
  return fmt::format(
      "{} ({} frames, {} matches): rows {} (spread {:.2f} px), right camera pitch {}, yaw {}, roll "
      "{}; ToF camera pitch {}, yaw {}, roll {}, ranges {}",
      VerdictText(change.verdict), change.frames, change.matches,
      Seen(change.rows_px, change.rows_sigma_px, 1, 2, "px"), change.rows_spread_px,
      Pixels(change.right, 0, pair.focal_px), Pixels(change.right, 1, pair.focal_px),
      Degrees(change.right, 2), Pixels(change.tof, 0, pair.focal_px),
      Pixels(change.tof, 1, pair.focal_px), Degrees(change.tof, 2),
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

}  // namespace sprout::selfcalibrate
