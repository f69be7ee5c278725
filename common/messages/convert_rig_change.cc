#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>

#include "common/core/checks.h"
#include "common/core/printable.h"
#include "common/messages/convert.h"

namespace sprout {
namespace {

constexpr int32_t kMaxFrames = 1000;
// A standard deviation that is not known.
constexpr double kNotShown = -1;

SeenTurn TurnOf(const double (&turn)[3], const double (&sigma)[3]) {
  return {.turn = Eigen::Vector3d(turn), .sigma = Eigen::Vector3d(sigma)};
}

void CheckDeviation(Checks& checks, const std::string& field, double sigma) {
  checks.Finite(field.c_str(), sigma)
      .Require(sigma == kNotShown || sigma >= 0, field.c_str(), sigma,
               "0 or more, or -1 for not shown");
}

void CheckTurn(Checks& checks, const std::string& name, const SeenTurn& seen) {
  for (Eigen::Index i = 0; i < 3; ++i) {
    checks.Finite((name + "_turn").c_str(), seen.turn[i]);
    CheckDeviation(checks, name + "_sigma", seen.sigma[i]);
  }
}

// A number that is not 0 must be significant, and 0 if it was not measured.
void CheckNumber(Checks& checks, const std::string& field, double number, double sigma) {
  constexpr int kSigmas = 3;
  constexpr double kRounding = 1e-6;
  if (sigma == kNotShown) {
    checks.Require(number == 0, field.c_str(), number, "0, as its sigma is -1 (not shown)");
  } else {
    std::ostringstream allowed;
    allowed << "0, or " << kSigmas << " times its sigma (" << sigma << ") or more";
    checks.Require(number == 0 || std::abs(number) >= kSigmas * sigma * (1 - kRounding),
                   field.c_str(), number, allowed.str());
  }
}

void CheckNumbers(Checks& checks, const RigChange& change) {
  bool is_change = false;
  bool needs_tof = change.range_offset_m != 0;
  for (Eigen::Index i = 0; i < 3; ++i) {
    CheckNumber(checks, "right_turn", change.right.turn[i], change.right.sigma[i]);
    CheckNumber(checks, "tof_turn", change.tof.turn[i], change.tof.sigma[i]);
    is_change = is_change || change.right.turn[i] != 0;
    needs_tof = needs_tof || change.tof.turn[i] != 0;
  }
  CheckNumber(checks, "range_offset_m", change.range_offset_m, change.range_sigma_m);
  is_change = is_change || needs_tof;
  checks.Require(!is_change || change.matches > 0, "matches", change.matches, "1 or more")
      .Require(!needs_tof || change.tof_matches > 0, "tof_matches", change.tof_matches,
               "1 or more for a change of the ToF camera")
      .Require(is_change || change.verdict != RigChange::Verdict::kWrong, "verdict",
               static_cast<int>(change.verdict), "WRONG only with a change");
}

}  // namespace

rig_change_t ToMessage(const RigChange& change) {
  rig_change_t message;
  message.header = ToMessage(change.newest_frame);
  message.reason = Shortened(change.reason, kMaxTextLength);
  message.verdict = static_cast<int32_t>(change.verdict);
  message.frames = change.frames;
  message.matches = change.matches;
  message.tof_matches = change.tof_matches;
  message.rows_px = change.rows_px;
  message.rows_spread_px = change.rows_spread_px;
  message.rows_sigma_px = change.rows_sigma_px;
  std::ranges::copy(change.right.turn, message.right_turn);
  std::ranges::copy(change.right.sigma, message.right_sigma);
  std::ranges::copy(change.tof.turn, message.tof_turn);
  std::ranges::copy(change.tof.sigma, message.tof_sigma);
  message.range_offset_m = change.range_offset_m;
  message.range_sigma_m = change.range_sigma_m;
  return message;
}

Result<RigChange> FromMessage(const rig_change_t& message) {
  Result<FrameId> newest_frame = FromMessage(message.header);
  if (!newest_frame) return tl::unexpected(newest_frame.error());
  RigChange change{.newest_frame = *std::move(newest_frame),
                   .reason = message.reason,
                   .frames = message.frames,
                   .matches = message.matches,
                   .tof_matches = message.tof_matches,
                   .rows_px = message.rows_px,
                   .rows_spread_px = message.rows_spread_px,
                   .rows_sigma_px = message.rows_sigma_px,
                   .right = TurnOf(message.right_turn, message.right_sigma),
                   .tof = TurnOf(message.tof_turn, message.tof_sigma),
                   .range_offset_m = message.range_offset_m,
                   .range_sigma_m = message.range_sigma_m};
  Checks checks;
  checks.Length("reason", message.reason, kMaxTextLength)
      .Require(message.verdict >= rig_change_t::VERDICT_UNSEEN &&
                   message.verdict <= rig_change_t::VERDICT_WRONG,
               "verdict", message.verdict, "UNSEEN, RIGHT or WRONG")
      .Require(message.frames >= 1 && message.frames <= kMaxFrames, "frames", message.frames,
               "1 to 1000")
      .NotNegative("matches", message.matches)
      .Require(message.tof_matches >= 0 && message.tof_matches <= message.matches, "tof_matches",
               message.tof_matches, "0 to matches")
      .Finite("rows_px", message.rows_px)
      .Finite("rows_spread_px", message.rows_spread_px)
      .Finite("range_offset_m", message.range_offset_m);
  CheckDeviation(checks, "rows_sigma_px", message.rows_sigma_px);
  CheckDeviation(checks, "range_sigma_m", message.range_sigma_m);
  CheckTurn(checks, "right", change.right);
  CheckTurn(checks, "tof", change.tof);
  if (!checks.ok()) return checks.error();
  change.verdict = static_cast<RigChange::Verdict>(message.verdict);
  if (change.verdict != RigChange::Verdict::kUnseen) CheckNumbers(checks, change);
  if (!checks.ok()) return checks.error();
  return change;
}

}  // namespace sprout
