#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "common/core/tof_image.h"
#include "common/inputs/judges.h"

namespace sprout::inputs {
namespace {

struct RangeVerdicts {
  static constexpr int kFewCompared = 25;   ///< matches that say something of the ranges
  static constexpr int kSomeCompared = 40;  ///< and of moves, which differ less
  static constexpr double kSure = 4;        ///< standard deviations, see MoreAgree()
  static constexpr double kHits = 0.02;     ///< share of the values that has to hit the picture
  /// Share of those in the left picture that has to hit the right one, too, where there are many.
  static constexpr double kHitsBoth = 0.05;
  static constexpr int kManyInPicture = 100;
  /// Shares of the matches that agree: 0.81 to 1 in good frames.
  static constexpr double kGood = 0.7;         ///< the scale is right; or a move explains the frame
  static constexpr double kOfOneMoment = 0.8;  ///< ranges and images are of one moment
  static constexpr double kHalf = 0.5;         ///< least of another turn or scale
  /// By how much more must agree with another turn, scale, or move ahead than with none.
  static constexpr double kTurnedGain = 0.2;
  static constexpr double kScaledGain = 0.25;
  static constexpr double kMovedGain = 0.1;
  static constexpr double kMovedSure = 2.5;   ///< standard deviations of that of a move
  static constexpr double kMinFactor = 0.03;  ///< of |ln(factor)|: less is a device's own error
  /// Up to 2.7 where a device's own error or a moved sensor explains more; displaced by 3 % of the
  /// picture from 2.8 on.
  static constexpr double kShiftedSure = 3;
  static constexpr double kShiftedGain = 0.08;  ///< as kMovedGain, of moves in the picture
  /// Neighbours that show noise: so many pairs at least, and such a share of the returns (0.08 of
  /// KITTI's scans; points of two surfaces that meet in one place are 0.025), and the share of them
  /// that are apart (at most 0.08 in a scene).
  static constexpr int kFewPairs = 100;
  static constexpr double kPairsOfReturns = 0.05;
  static constexpr double kNoise = 0.5;
  /// Smaller moves may be a device's own error, which Refiner corrects or reports.
  static constexpr double kMinMoveM = 0.2;
};

// A unit that ranges may have: true metres a metre that was read, what to ask, and --tof-unit.
struct UnitRow {
  double factor;
  const char* text;
  const char* unit;
};
constexpr UnitRow kUnits[] = {
    {1000.0 / 256, "is the file in 1/256 m, and read as mm?", "1/256"},
    {1000.0 / 5000, "is the file in 1/5000 m, and read as mm?", "1/5000"},
    {1e-3, "are they in mm, and read as m, or is the baseline in m, and read as mm?", "mm"},
    {1e3, "are they in m, and read as mm, or is the baseline in mm, and read as m?", "m"},
    {10, "are they in cm, and read as mm?", "cm"},
    {1e-2, "are they in cm, and read as m?", "cm"},
    {0.1, "are they in 1/10 mm, and read as mm?", "1/10000"},
    {0.25, "are they in 1/4 mm, and read as mm?", "1/4000"},
    {0.125, "are they in 1/8 mm, and read as mm?", "1/8000"},
    {1.0 / 256, "are they in 1/256 m, and read as m?", "1/256"},
    {1.0 / 5000, "are they in 1/5000 m, and read as m?", "1/5000"},
    {0.3048, "are they in feet, and read as m, or in 1/1000 foot, and read as mm?",
     "0.3048 or 0.0003048"},
};
constexpr UnitRow kOtherUnit = {
    1, "do focal length and baseline, and the principal points, belong to these images?", ""};

const UnitRow& UnitOf(double factor, double sigma) {
  const UnitRow* best = &kOtherUnit;
  double least = std::max(0.03, 4 * sigma / factor);
  for (const UnitRow& unit : kUnits) {
    const double off = std::abs(std::log(factor / unit.factor));
    if (off >= least) continue;
    least = off;
    best = &unit;
  }
  return *best;
}

std::string FlagOf(std::string_view unit) {
  return unit.empty() ? "" : "--tof-unit " + std::string(unit);
}

const char* NameOf(const Turn& turn) {
  if (turn.transposed) {
    if (turn.mirrored == turn.upside_down) {
      return turn.mirrored ? "mirrored about its other diagonal" : "mirrored about its diagonal";
    }
    return turn.mirrored ? "turned by 90°: turn it clockwise"
                         : "turned by 90°: turn it counter-clockwise";
  }
  if (turn.mirrored) return turn.upside_down ? "turned by 180°" : "mirrored left to right";
  return "upside down";
}

bool IsScaled(const RangeModel& model) {
  const Agreement& scaled = model.scaled;
  return scaled.compared >= RangeVerdicts::kFewCompared && scaled.share() >= RangeVerdicts::kHalf &&
         scaled.share() - model.as_is.share() >= RangeVerdicts::kScaledGain &&
         std::abs(std::log(scaled.with.factor)) > RangeVerdicts::kMinFactor &&
         scaled.agreeing >= model.turned.agreeing && scaled.close >= model.moved.close &&
         // If ranges are far off, none of them may be comparable.
         (model.as_is.compared < RangeVerdicts::kFewCompared ||
          MoreAgree(scaled, model.as_is) >= RangeVerdicts::kSure ||
          model.as_is.compared < scaled.compared / 2);
}

// Whether another reading of the ranges fits that no factor explains.
bool IsMisread(const RangeModel& model) {
  const Agreement& misread = model.misread;
  return misread.compared >= RangeVerdicts::kFewCompared &&
         misread.share() >= RangeVerdicts::kGood &&
         misread.share() - std::max(model.as_is.share(), model.scaled.share()) >=
             RangeVerdicts::kScaledGain &&
         misread.agreeing >= model.turned.agreeing && misread.close >= model.moved.close;
}

// Variance of a share, with one more match of either kind, so that 0 and n of n are not certain.
double Variance(const Agreement& agreement) {
  const double n = agreement.compared + 2;
  const double share = (agreement.agreeing + 1) / n;
  return share * (1 - share) / n;
}

// Turned points lie around other matches, so shares are compared as well.
bool AreApart(const Agreement& one, const Agreement& other) {
  return MoreAgree(one, other) >= RangeVerdicts::kSure ||
         one.share() - other.share() >=
             RangeVerdicts::kSure * std::sqrt(Variance(one) + Variance(other));
}

bool IsTurned(const RangeModel& model) {
  const Agreement& turned = model.turned;
  return turned.compared >= RangeVerdicts::kFewCompared && turned.share() >= RangeVerdicts::kHalf &&
         turned.share() - model.as_is.share() >= RangeVerdicts::kTurnedGain &&
         AreApart(turned, model.as_is);
}

bool IsMoved(const RangeModel& model) {
  const Agreement& moved = model.moved;
  return moved.compared >= RangeVerdicts::kSomeCompared &&
         std::abs(moved.with.ahead_m) >= RangeVerdicts::kMinMoveM &&
         moved.close_share() >= RangeVerdicts::kGood &&
         moved.close_share() - model.as_is.close_share() >= RangeVerdicts::kMovedGain &&
         MoreAgree(moved, model.as_is, Vote::kIsClose) >= RangeVerdicts::kMovedSure;
}

// Whether points at other places in the picture explain what those as they are do not.
bool IsElsewhere(const RangeModel& model, const Agreement& elsewhere) {
  return elsewhere.compared >= RangeVerdicts::kSomeCompared &&
         elsewhere.close_share() >= RangeVerdicts::kGood &&
         elsewhere.close_share() - model.as_is.close_share() >= RangeVerdicts::kShiftedGain &&
         MoreAgree(elsewhere, model.as_is, Vote::kIsClose) >= RangeVerdicts::kShiftedSure &&
         elsewhere.close_share() > std::max(model.moved.close_share(), model.scaled.close_share());
}

bool IsSpread(const RangeModel& model) {
  return model.spread.close_share() > model.shifted.close_share() &&
         IsElsewhere(model, model.spread);
}

// Whether the range image as a whole is what is wrong, so that its parts need no cure.
bool IsExplained(const RangeModel& model) {
  return IsScaled(model) || IsMisread(model) || IsTurned(model) || IsSpread(model) ||
         IsElsewhere(model, model.shifted);
}

double Share(int some, int all) { return all == 0 ? 0 : static_cast<double>(some) / all; }

std::string ReturnsText(const RangeModel& model) {
  return fmt::format(
      "{} of {} pixels of the range image have a return, {} of them fall into the picture",
      model.returns, model.pixels, std::min(model.in_picture, model.returns));
}

// Whether points lie too near for the right camera to see them: they become no seeds, and are never
// compared.
bool AreTooNear(const RangeModel& model) {
  return model.in_picture >= RangeVerdicts::kManyInPicture &&
         model.in_both < RangeVerdicts::kHitsBoth * model.in_picture;
}

// Whether a number stands for no range, and nothing else is wrong.
bool HasNoReturn(const RangeModel& model) {
  return model.repeated.count > 0 && model.repeated.MeansNothing() && !AreTooNear(model) &&
         !IsExplained(model);
}

// What is wrong with the ranges by themselves; empty: nothing.
std::string FaultOf(const RangeModel& model) {
  if (HasNoReturn(model)) {
    return fmt::format(
        "{} pixels of the range image have exactly {:.3f} m, and stereo sees no such wall: is that "
        "what the sensor says where it measures nothing? give 0 there",
        model.repeated.count, model.repeated.depth_m);
  }
  if (model.repeated.are_whole_m) {
    return "all ranges are whole metres: were decimals cut off? give mm, or floating point";
  }
  const double apart = Share(model.apart, model.pairs);
  const double least_pairs = RangeVerdicts::kPairsOfReturns * model.returns;
  if (model.pairs >= std::max<double>(RangeVerdicts::kFewPairs, least_pairs) &&
      apart > RangeVerdicts::kNoise) {
    return fmt::format(
        "{:.0f} % of the ranges side by side differ by more than a tenth: is it noise, or are "
        "bytes in another order?",
        100 * apart);
  }
  if (AreTooNear(model)) {
    return fmt::format(
        "{} of {} range points in the left picture lie outside the right one, as what is too near: "
        "in which unit are ranges, where does the range sensor stand (rig file), and "
        "do focal length and baseline belong to these images?",
        model.in_picture - model.in_both, model.in_picture);
  }
  if (model.returns > 0) {
    if (Share(model.in_picture, model.values) >= RangeVerdicts::kHits) return "";
    return ReturnsText(model) +
           ": where does the range sensor stand, and in which unit are ranges (rig file)?";
  }
  if (model.values > 0) {
    return fmt::format("all {} ranges are beyond {:.0f} m: are they in mm, and read as m?",
                       model.values, kMaxTofDepthM);
  }
  return fmt::format(
      "none of the {} pixels of the range image has a return, a depth above 0: is the range "
      "sensor running, and does it look where the cameras do?",
      model.pixels);
}

Finding JudgeHits(const RangeModel& model) {
  const std::string fault = FaultOf(model);
  return {.question = Question::kHits,
          .verdict = fault.empty() ? Verdict::kGood : Verdict::kBad,
          .value = 100 * Share(model.in_picture, model.values),
          .sigma = 0,
          .text = fault.empty() ? ReturnsText(model) : fault,
          .flag = model.returns == 0 && model.values > 0 ? FlagOf("mm") : "",
          .no_return_m = HasNoReturn(model) ? model.repeated.depth_m : 0};
}

std::string SideText(double px, const char* less, const char* more) {
  return fmt::format("{:.0f} px further {}", std::abs(px), px > 0 ? more : less);
}

Finding JudgePlace(const RangeModel& model) {
  Finding finding{.question = Question::kPlace};
  const Agreement& as_is = model.as_is;
  finding.value = 100 * (as_is.share() - model.turned.share());
  finding.sigma = 100 * std::sqrt(Variance(as_is) + Variance(model.turned));
  if (IsTurned(model)) {
    finding.verdict = Verdict::kBad;
    finding.text = fmt::format(
        "the range image is {} (then ranges agree with stereo at {:.0f} % of "
        "the matches, as it is at {:.0f} %)",
        NameOf(model.turned.with.turn), 100 * model.turned.share(), 100 * as_is.share());
  } else if (IsElsewhere(model, model.shifted) && !IsSpread(model)) {
    finding.verdict = Verdict::kBad;
    finding.moved_px = cv::norm(model.shifted.with.move_px);
    finding.text = fmt::format(
        "range points belong about {} in the left image (there {:.0f} % of them are within 1 % of "
        "stereo, where they are {:.0f} %): how does the range sensor lie in the rig? "
        "sprout-calibrate refine",
        MoveText(model.shifted.with.move_px), 100 * model.shifted.close_share(),
        100 * as_is.close_share());
  } else if (as_is.compared >= RangeVerdicts::kFewCompared &&
             as_is.share() >= RangeVerdicts::kHalf && AreApart(as_is, model.turned)) {
    finding.verdict = Verdict::kGood;
    finding.text =
        fmt::format("{:.0f} % of the ranges agree with stereo, turned otherwise at most {:.0f} %",
                    100 * as_is.share(), 100 * model.turned.share());
  } else {
    finding.text = fmt::format(
        "ranges agree with stereo at {:.0f} % of {} matches, turned otherwise "
        "at {:.0f} %: too alike, or too few, to tell",
        100 * as_is.share(), as_is.compared, 100 * model.turned.share());
  }
  return finding;
}

std::string SpreadText(const cv::Point2d& spread) {
  const bool are_alike = std::abs(spread.y / spread.x - 1) < 1e-6;
  return are_alike ? fmt::format("{:.2f}", spread.x)
                   : fmt::format("{:.2f} (across) and {:.2f} (down)", spread.x, spread.y);
}

Finding JudgeScale(const RangeModel& model, bool is_turned) {
  Finding finding{
      .question = Question::kScale, .value = model.ratio.value, .sigma = model.ratio.sigma};
  if (IsMisread(model)) {
    finding.verdict = Verdict::kBad;
    finding.text =
        fmt::format(fmt::runtime(TextOf(model.misread.with.reading)), 100 * model.misread.share());
  } else if (IsScaled(model)) {
    const double factor = 1 / model.ratio.value;
    const double sigma = factor * model.ratio.sigma / model.ratio.value;
    const bool is_short = factor > 1;
    finding.verdict = Verdict::kBad;
    const UnitRow& unit = UnitOf(factor, sigma);
    finding.text =
        fmt::format("ranges are {:.4g} ± {:.1g} times too {}: {}", is_short ? factor : 1 / factor,
                    is_short ? sigma : model.ratio.sigma, is_short ? "short" : "long", unit.text);
    finding.flag = FlagOf(unit.unit);
  } else if (!is_turned && IsSpread(model)) {
    finding.verdict = Verdict::kBad;
    finding.text = fmt::format(
        "the range image has {} times the field of view that it is taken for (then {:.0f} % of its "
        "points are within 1 % of stereo, as it is {:.0f} %): give the sensor's own lens "
        "(--tof-rig, CameraInfo)",
        SpreadText(model.spread.with.spread), 100 * model.spread.close_share(),
        100 * model.as_is.close_share());
  } else if (!is_turned && model.as_is.compared >= RangeVerdicts::kFewCompared &&
             model.as_is.share() >= RangeVerdicts::kGood) {
    finding.verdict = Verdict::kGood;
    finding.text = fmt::format(
        "ranges are {:.3f} ± {:.3f} times those of stereo ({:+.0f} ± {:.0f} mm in the middle)",
        finding.value, finding.sigma, 1000 * model.offset_m.value, 1000 * model.offset_m.sigma);
  } else {
    finding.value = finding.sigma = Finding::kUnknown;
    finding.text = "too few matches agree with the ranges to tell their scale";
  }
  return finding;
}

Finding JudgeMoment(const RangeModel& model, bool is_explained) {
  Finding finding{.question = Question::kMoment};
  const Agreement& as_is = model.as_is;
  const double share = as_is.share();
  const double sigma = std::sqrt(Variance(as_is));
  finding.value = 100 * (1 - share);
  finding.sigma = 100 * sigma;
  if (is_explained || as_is.compared < RangeVerdicts::kFewCompared) {
    finding.text = is_explained
                       ? "ranges do not fit the images for another reason"
                       : fmt::format("range points lie around {} matches only", as_is.compared);
  } else if (IsMoved(model)) {
    finding.verdict = Verdict::kBad;
    finding.text = fmt::format(
        "ranges and images disagree at {:.0f} ± {:.0f} % of the points, and fit from {:.1f} m "
        "further {}: is the range image of another moment (time stamps), or its sensor's place in "
        "the rig wrong?",
        100 * (1 - as_is.close_share()), finding.sigma, std::abs(model.moved.with.ahead_m),
        model.moved.with.ahead_m > 0 ? "ahead" : "back");
  } else if (as_is.compared >= RangeVerdicts::kSomeCompared &&
             share + 2 * sigma < RangeVerdicts::kOfOneMoment) {
    finding.verdict = Verdict::kBad;
    finding.text = fmt::format(
        "ranges and images disagree at {:.0f} ± {:.0f} % of the points: is the range image of "
        "another moment or another sensor, scaled to be looked at, or beyond its unambiguous range "
        "(refine.unambiguous_range_m)?",
        finding.value, finding.sigma);
  } else if (share >= RangeVerdicts::kOfOneMoment) {
    finding.verdict = Verdict::kGood;
    finding.text = fmt::format("ranges and images disagree at {:.0f} ± {:.0f} % of the points",
                               finding.value, finding.sigma);
  } else {
    finding.text =
        fmt::format("ranges and images disagree at {:.0f} ± {:.0f} % of {} points: too few to tell",
                    finding.value, finding.sigma, as_is.compared);
  }
  return finding;
}

}  // namespace

std::string MoveText(const cv::Point2d& move_px) {
  std::string text;
  if (std::abs(move_px.x) >= 0.5) text = SideText(move_px.x, "left", "right");
  if (std::abs(move_px.y) >= 0.5) {
    text += (text.empty() ? "" : " and ") + SideText(move_px.y, "up", "down");
  }
  return text;
}

Findings JudgeRanges(const RangeModel* ranges, bool pair_fits) {
  Findings findings;
  if (ranges == nullptr) {
    findings.push_back({.question = Question::kHits, .text = "there is no range image"});
  } else {
    findings.push_back(JudgeHits(*ranges));
  }
  if (ranges == nullptr || !pair_fits) {
    for (const Question question : {Question::kPlace, Question::kScale, Question::kMoment}) {
      findings.push_back({.question = question,
                          .text = pair_fits ? "there is no range image"
                                            : "stereo itself has to be put right first"});
    }
    return findings;
  }
  findings.push_back(JudgePlace(*ranges));
  const bool is_turned = findings.back().verdict == Verdict::kBad;
  findings.push_back(JudgeScale(*ranges, is_turned));
  const bool is_scaled = findings.back().verdict == Verdict::kBad;
  findings.push_back(JudgeMoment(*ranges, is_turned || is_scaled));
  return findings;
}

}  // namespace sprout::inputs
