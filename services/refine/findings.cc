#include "services/refine/findings.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <vector>

#include "common/core/joined.h"
#include "common/inputs/judges.h"
#include "services/refine/range/range_rules.h"

namespace sprout::refine {
namespace {

// Maps are meant to be right within 1 px: a larger shift makes a frame degenerate.
constexpr double kSurelyOffPx = 1;

std::string NoSeedsText(const SeedSet& seeds, bool stereo_seeds) {
  const std::string text = seeds.raw == 0
                               ? "no ToF point has a return"
                               : fmt::format("none of {} ToF points became a seed", seeds.raw);
  if (stereo_seeds) return text + ", and stereo found none";
  if (seeds.raw > 0) return text;
  return text + "; seeds of stereo take refine { stereo_seeds: true }, as in preset default";
}

std::string ContradictionText(const Contradiction& contradiction) {
  const auto dropped = std::ranges::count(contradiction.points, 1);
  return fmt::format(
      "stereo contradicts the range points at {:.0f} % of its matches: {:.0f} % of the points are "
      "not believed",
      100 * contradiction.share,
      100.0 * static_cast<double>(dropped) / static_cast<double>(contradiction.points.size()));
}

std::string SmoothingText(const Smoothing& smoothing) {
  return fmt::format(
      "the range image is smoothed, its depth edges are {:.1f} pixels wide: the {:.0f} % of its "
      "points beside them are not believed",
      smoothing.edge_width, 100 * smoothing.dropped_share);
}

std::string FatteningText(const Fattening& fattening) {
  return fmt::format(
      "near surfaces of the range image reach up to {} pixel{} beyond their edges: the {:.0f} % of "
      "its points there are not believed",
      fattening.width, fattening.width == 1 ? "" : "s", 100 * fattening.dropped_share);
}

std::string WhereText(const SensorPlace& place) {
  if (place.scale != 1) {
    return fmt::format("{:.2f} times as far away (unit, focal length, baseline?)", 1 / place.scale);
  }
  if (place.spread != 1) {
    return fmt::format("{:.2f} times as far from the middle of the left image (is that its lens?)",
                       place.spread);
  }
  if (place.shear != 0) {
    return fmt::format(
        "{:.2f} px further {} for each px further down (does it scan row by row while it turns?)",
        std::abs(place.shear), place.shear > 0 ? "right" : "left");
  }
  if (place.in_right_image) {
    return "where the left camera sees them, and lie where the right one does (which matrix "
           "projects them?)";
  }
  return "about " + inputs::MoveText(place.move_px) + " in the left image";
}

std::string PlaceText(const SensorPlace& place) {
  return fmt::format(
      "range points belong {} (there {:.0f} % of them agree with stereo, where they are "
      "{:.0f} %): none is believed",
      WhereText(place), 100 * place.agree_moved, 100 * place.agree_as_is);
}

// Why no range point is believed, or should be, or why the images cannot judge them.
std::string RefusalText(const RefineFindings& found) {
  const RangeError& error = found.range_error;
  if (found.sensor_place.is_displaced) return PlaceText(found.sensor_place);
  if (error.rejected && !found.contradiction.points.empty()) {
    return ContradictionText(found.contradiction);
  }
  if (error.rejected) {
    return fmt::format(
        "the images contradict the range points in {} % of the places where they could show it: "
        "none is believed",
        std::lround(100 * error.contradicted_share));
  }
  if (error.rows_unfit) {
    return "the images fit the range points better on other rows than on their own, so they "
           "contradict none of them: is the pair rectified?";
  }
  if (error.rows_shifted) {
    return "each row of the right image fits the range points in columns of its own, so the "
           "images contradict none of them: are its rows exposed one after the other, or is a "
           "part of it of another moment?";
  }
  if (!error.pair_unfit && error.contradicted_share > RangeRules::kRejectedShare) {
    return fmt::format(
        "the images contradict the range points in {} % of the places where they could show it; "
        "all are believed, since range_bias is not FIELD",
        std::lround(100 * error.contradicted_share));
  }
  if (error.pair_unfit) {
    return "the images fit neither the range points nor each other, so they say nothing of the "
           "range sensor: are the pair's calibration, focus, exposure and moment right?";
  }
  return "";
}

// How many standard deviations of its own a knot is off.
double SigmasOf(const RangeKnot& knot) { return std::abs(knot.error_m) / knot.sigma_m; }

// Nearest, most and farthest of the knots whose error the images show; in a curve that is sure only
// as a whole, the surest of those that are off.
std::vector<RangeKnot> ShownKnots(const std::vector<RangeKnot>& curve) {
  constexpr double kStandardDeviations = 3;
  std::vector<RangeKnot> sure;
  std::ranges::copy_if(curve, std::back_inserter(sure),
                       [](const RangeKnot& knot) { return SigmasOf(knot) > kStandardDeviations; });
  if (sure.empty()) return {*std::ranges::max_element(curve, {}, SigmasOf)};
  const auto most = std::ranges::max_element(
      sure, {}, [](const RangeKnot& knot) { return std::abs(knot.error_m); });
  std::vector<RangeKnot> shown = {sure.front()};
  if (most != sure.begin()) shown.push_back(*most);
  if (most + 1 < sure.end()) shown.push_back(sure.back());
  return shown;
}

// How far the sensor is off, in mm with its standard deviation, at the nearest and the farthest
// depth and where it is most, and what share of the points was moved. Empty for a sensor that is
// right; nothing when the images do not show it, or contradict too many points.
std::optional<std::string> RangeErrorText(const RangeError& error) {
  if (error.curve.empty() || error.RejectsAll()) return std::nullopt;
  const std::string moved = fmt::format("{:.0f} % of its points were moved by more than {} px",
                                        100 * error.far_moved_share, RangeRules::kFarMovePx);
  if (error.curve_is_zero) {
    constexpr double kMinShare = 0.005;  // that is more than 0 %
    if (error.far_moved_share < kMinShare) return "";
    return "the range sensor is off as by multi-path: " + moved;
  }
  const std::vector<RangeKnot> shown = ShownKnots(error.curve);
  if (SigmasOf(shown.front()) < 1) return "the range sensor is off, at no depth for sure: " + moved;
  std::string knots;
  for (const RangeKnot& knot : shown) {
    knots += fmt::format("{}{:+.1f} ± {:.1f} mm at {:.2f} m", knots.empty() ? "" : ", ",
                         1000 * knot.error_m, 1000 * knot.sigma_m, knot.depth_m);
  }
  const std::string same = error.same_px == 0
                               ? ""
                               : fmt::format(
                                     ", about {:+.1f} px at all depths, as if not the sensor but "
                                     "the right camera of the pair were turned",
                                     error.same_px);
  return fmt::format(
      "depths of the range sensor are off by {}{}; {}. If that stays so: sprout-calibrate refine",
      knots, same, moved);
}

}  // namespace

std::string DegenerateText(const RefineFindings& found, const SeedSet& seeds, bool stereo_seeds) {
  std::string text = seeds.seeds.empty() ? NoSeedsText(seeds, stereo_seeds) : "";
  text = JoinedTexts(text, RefusalText(found));
  if (const std::optional<RangeKnot>& absurd = found.range_error.absurd) {
    text =
        JoinedTexts(text, fmt::format("ranges are off by {:+.2f} m at {:.2f} m, more than a sensor "
                                      "can be: none is believed; are their unit, the focal length "
                                      "and the baseline right?",
                                      absurd->error_m, absurd->depth_m));
  }
  if (std::abs(found.range_error.same_px) >= kSurelyOffPx) {
    text = JoinedTexts(
        text, fmt::format("range sensor and pair differ by about {:+.1f} px at all depths, "
                          "as where the right camera is turned: one frame cannot tell "
                          "which of them is wrong, and the images were believed",
                          found.range_error.same_px));
  }
  if (!found.are_noise) return text;
  return JoinedTexts(text,
                     fmt::format("{} of {} range points differ from all around them, as noise "
                                 "does: none is believed",
                                 seeds.loose, seeds.raw));
}

std::optional<std::string> FindingText(const RefineFindings& found) {
  std::optional<std::string> text = RangeErrorText(found.range_error);
  // Where no point is believed, what its edges look like would mislead.
  if (found.range_error.rejected) return text;
  const auto put_first = [&](const std::string& finding) {
    text = JoinedTexts(finding, text.value_or(""));
  };
  if (!found.contradiction.points.empty()) put_first(ContradictionText(found.contradiction));
  if (found.smoothing) put_first(SmoothingText(found.smoothing));
  if (found.fattening) put_first(FatteningText(found.fattening));
  if (found.scan_move.is_off) put_first(ScanMoveText(found.scan_move));
  return text;
}

}  // namespace sprout::refine
