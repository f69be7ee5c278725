#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/core/quantile.h"
#include "common/inputs/judges.h"

namespace sprout::inputs {
namespace {

struct PairRules {
  static constexpr size_t kFewInliers = 25;     ///< matches that say something of the pair
  static constexpr double kMaxOfMatches = 0.5;  ///< of them agree in a good pair: 0.6 to 1
  static constexpr double kBeyondChance = 6;    ///< standard deviations
  static constexpr int kFewFeatures = 100;      ///< corners in each image that say that none match
  /// So many of the corners of two scenes find a partner by chance: at most 0.03 were seen, in good
  /// pairs at least 0.35.
  static constexpr double kChanceOfFeatures = 0.12;
  /// Beyond it Sprout loses accuracy that can be measured (services/tools/calibrate/NOTES.md).
  static constexpr double kMaxRowsPx = 1;
  static constexpr double kMaxParallaxPx = 1;
  /// Rows that are off alike move no columns, but growth claims more than it finds on them: about
  /// as much as with columns that are off by this part, with rows 2 to 5 px off.
  static constexpr double kEvenRows = 0.5;
  static constexpr double kSureBent = 4;  ///< standard deviations
  /// The same of columns that another scale moves; in good pairs these lie at most 0.4 px above it.
  static constexpr double kSureScale = 4;
  static constexpr double kSides = 0.375;  ///< of the width: from its middle to the outermost cells
  /// Parallax that row errors may cause, as a share of the largest of them: (1) is a pitch's and a
  /// roll's first order only.
  static constexpr double kParallaxOfRows = 0.1;
  static constexpr double kSure = 5;  ///< standard deviations
  /// Right over left or left over right: 0.83 (ETH3D's playground) to 1.01 in good pairs. At 0.8
  /// preset `fast` loses most of its pixels, from 0.7 on `default` much confidence (NOTES.md).
  static constexpr double kMaxContrast = 1.23;
  /// Beyond it, EXPSSD with the default σ_s² rejects a window that fits in all else (τ).
  static constexpr double kMaxBrightness = 1.27;
};

// Whether more matches agree than would by chance.
bool AreMany(const PairModel& model) {
  const auto inliers = static_cast<double>(model.inliers.size());
  return inliers >= PairRules::kFewInliers &&
         inliers > model.by_chance.value + PairRules::kBeyondChance * model.by_chance.sigma;
}

Finding JudgeScene(const Matches& matches, const PairModel& model) {
  Finding finding{.question = Question::kScene};
  const auto inliers = static_cast<double>(model.inliers.size());
  const int features = std::min(matches.left_features, matches.right_features);
  finding.value = 100 * inliers / std::max(1, matches.left_features);
  finding.sigma = 100 * std::sqrt(std::max(1.0, inliers)) / std::max(1, matches.left_features);
  if (ShowOneScene(model)) {
    finding.verdict = Verdict::kGood;
    finding.text =
        fmt::format("{} of {} corners are in both images", inliers, matches.left_features);
  } else if (features >= PairRules::kFewFeatures && !AreMany(model) &&
             inliers + 3 * std::sqrt(inliers) < PairRules::kChanceOfFeatures * features) {
    finding.verdict = Verdict::kBad;
    finding.text = fmt::format(
        "left and right do not show one scene: {} of {} corners are in both; are these files of "
        "one pair, and its rows within {:.0f} px?",
        inliers, matches.left_features, matches.most_rows_px);
  } else {
    finding.text = fmt::format(
        "{} of {} corners are in both images: too few to tell whether they show one scene", inliers,
        matches.left_features);
  }
  return finding;
}

Finding JudgeTime(const PairModel& model) {
  Finding finding{.question = Question::kTime,
                  .value = model.parallax_px.value,
                  .sigma = model.parallax_px.sigma};
  std::vector<double> disparities;
  for (const Match& match : model.inliers) disparities.push_back(std::abs(match.disparity()));
  // What a roll of either camera may add, see (1): x is between the two places of a match.
  const double by_roll = std::abs(model.roll_rad) * Median(disparities) / 2;
  const double by_rows = PairRules::kParallaxOfRows * std::abs(model.worst_px.value);
  const double most = PairRules::kMaxParallaxPx + by_roll + by_rows;
  const double sure = PairRules::kSure * finding.sigma;
  if (finding.value - sure > most) {
    finding.verdict = Verdict::kBad;
    finding.text = fmt::format(
        "near things lie {:.1f} ± {:.1f} px off the rows of far ones: left and right are not of "
        "one moment, or the right camera stands elsewhere than calibrated",
        finding.value, finding.sigma);
  } else if (finding.value + 2 * finding.sigma < most &&
             std::abs(model.worst_px.value) < PairRules::kMaxRowsPx) {
    finding.verdict = Verdict::kGood;
    finding.text =
        fmt::format("near and far things lie on the same rows to {:.2f} px", finding.value);
  } else {
    finding.text = "rows do not tell whether left and right are of one moment";
  }
  return finding;
}

// Turned cameras, and lenses whose distortion is still in the images, bend the rows.
bool RowsAreBent(const PairModel& model) {
  return std::abs(model.bent_px.value) - PairRules::kSureBent * model.bent_px.sigma >
         PairRules::kMaxRowsPx;
}

// How far columns at the sides are off since one image is larger: rows show its scale, which is the
// same in both directions. Nothing where that is not sure, or less than rows are off.
std::optional<Estimate> ColumnsOff(const PairModel& model, int width) {
  const double from_middle_px = PairRules::kSides * width;
  const double off_px = std::abs(model.stretch.value) * from_middle_px;
  const double sigma_px = model.stretch.sigma * from_middle_px;
  const double most = std::max(PairRules::kMaxRowsPx, std::abs(model.worst_px.value));
  if (off_px - PairRules::kSureScale * sigma_px <= most) return {};
  return Estimate{off_px, sigma_px};
}

Finding JudgeRows(const PairModel& model, int width) {
  Finding finding{
      .question = Question::kRows, .value = model.worst_px.value, .sigma = model.worst_px.sigma};
  const double off = std::abs(finding.value);
  const bool are_off = off - finding.sigma > PairRules::kMaxRowsPx;
  const auto say_bad = [&](const Estimate& estimate, std::string text) {
    finding.verdict = Verdict::kBad;
    finding.value = estimate.value;
    finding.sigma = estimate.sigma;
    finding.text = std::move(text);
  };
  if (!are_off && RowsAreBent(model)) {
    say_bad(model.bent_px,
            fmt::format(
                "rows of the right image are bent against those of the left one, by up to {:+.2f} "
                "± {:.2f} px ({} are allowed): rectify the pair, with the distortion of its lenses",
                model.bent_px.value, model.bent_px.sigma, PairRules::kMaxRowsPx));
  } else if (const std::optional<Estimate> columns_px = ColumnsOff(model, width)) {
    say_bad(*columns_px,
            fmt::format(
                "the right image shows things {:+.2f} ± {:.2f} % larger, so columns at its sides "
                "are off by {:.1f} px ({} are allowed): give both images one focal length and "
                "size, or rectify the pair; or is it of another moment, and the rig drives?",
                100 * model.stretch.value, 100 * model.stretch.sigma, columns_px->value,
                PairRules::kMaxRowsPx));
  } else if (are_off) {
    say_bad(
        model.worst_px,
        fmt::format(
            "rows of the right image lie {:+.2f} ± {:.2f} px off those of the left one in the "
            "middle, up to {:+.2f} px elsewhere (roll {:+.2f}°; {} px are allowed): rectify the "
            "pair, or correct the rig with sprout-calibrate refine",
            model.middle_px.value, model.middle_px.sigma, finding.value,
            model.roll_rad * 180 / std::numbers::pi, PairRules::kMaxRowsPx));
  } else if (off + finding.sigma < PairRules::kMaxRowsPx) {
    finding.verdict = Verdict::kGood;
    finding.text = fmt::format("rows agree to {:+.2f} ± {:.2f} px", finding.value, finding.sigma);
  } else {
    finding.text = fmt::format("rows may be off by {:+.2f} ± {:.2f} px ({} are allowed)",
                               finding.value, finding.sigma, PairRules::kMaxRowsPx);
  }
  return finding;
}

Finding CannotTell(Question question) {
  return {.question = question, .text = "too few corners are in both images"};
}

struct Window {
  double brightness = 0;  // mean of the grey values
  double contrast = 0;    // their standard deviation; 0 beside the border
};

Window WindowAt(const cv::Mat1b& image, const cv::Point2d& at) {
  constexpr int kReach = 5;
  const cv::Rect window(cvRound(at.x) - kReach, cvRound(at.y) - kReach, 2 * kReach + 1,
                        2 * kReach + 1);
  if ((window & cv::Rect({}, image.size())) != window) return {};
  cv::Scalar mean, sigma;
  cv::meanStdDev(image(window), mean, sigma);
  return {mean[0], sigma[0]};
}

// The contrast and the brightness of the right image over those of the left one, by what both show.
Finding JudgeContrast(const cv::Mat1b& left, const cv::Mat1b& right, const PairModel& model) {
  std::vector<double> logs;
  std::vector<double> bright_logs;
  for (const Match& match : model.inliers) {
    const Window of_left = WindowAt(left, match.left);
    const Window of_right = WindowAt(right, match.right);
    if (of_left.contrast > kBlankContrast && of_right.contrast > kBlankContrast) {
      logs.push_back(std::log(of_right.contrast / of_left.contrast));
      bright_logs.push_back(std::log(of_right.brightness / of_left.brightness));
    }
  }
  if (logs.size() < PairRules::kFewInliers) {
    return FindBlur(left, right).value_or(CannotTell(Question::kContrast));
  }
  Finding finding{.question = Question::kContrast};
  const Estimate log = MedianOf(std::move(logs));
  finding.value = std::exp(log.value);
  finding.sigma = finding.value * log.sigma;
  const bool is_bad = std::abs(log.value) > std::log(PairRules::kMaxContrast);
  finding.verdict = is_bad ? Verdict::kBad : Verdict::kGood;
  finding.text = fmt::format("what both images show has {:.2f} times the contrast in the right one",
                             finding.value);
  if (is_bad) {
    finding.text += ": give both cameras one exposure, gain and focus, and both files as many bits";
    return finding;
  }
  const Estimate bright_log = MedianOf(std::move(bright_logs));
  if (std::abs(bright_log.value) <= std::log(PairRules::kMaxBrightness)) return finding;
  finding.verdict = Verdict::kBad;
  finding.value = std::exp(bright_log.value);
  finding.sigma = finding.value * bright_log.sigma;
  finding.text = fmt::format(
      "what both images show is {:.2f} times as bright in the right one: give both cameras one "
      "exposure, gain, gamma and black level",
      finding.value);
  return finding;
}

}  // namespace

bool ShowOneScene(const PairModel& model) {
  return AreMany(model) &&
         static_cast<double>(model.inliers.size()) >= PairRules::kMaxOfMatches * model.tried;
}

double ColumnErrorPx(const PairModel& model, int width) {
  if (!AreMany(model)) return 0;
  double error_px = 0;
  const Finding time = JudgeTime(model);
  if (time.verdict == Verdict::kBad) error_px = time.value;
  if (const std::optional<Estimate> columns_px = ColumnsOff(model, width)) {
    error_px = std::max(error_px, columns_px->value);
  }
  const double middle_px = model.middle_px.value;
  const double worst_px = model.worst_px.value;
  if (std::abs(worst_px) - model.worst_px.sigma > PairRules::kMaxRowsPx) {
    const double even_px = PairRules::kEvenRows * std::abs(middle_px);
    error_px = std::max(error_px, std::abs(worst_px - middle_px) + even_px);
  } else if (RowsAreBent(model)) {
    error_px = std::max(error_px, std::abs(model.bent_px.value));
  }
  return error_px;
}

Findings JudgePair(const cv::Mat1b& left, const cv::Mat1b& right, const RectifiedPair& pair,
                   const Matches& matches, const PairModel& model, const RangeModel* ranges) {
  Findings findings = {JudgeScene(matches, model)};
  const bool is_one_scene = findings[0].verdict != Verdict::kBad;
  if (is_one_scene && model.inliers.size() >= PairRules::kFewInliers) {
    findings.push_back(JudgeTime(model));
    findings.push_back(JudgeSides(left, right, pair, model, ranges));
    findings.push_back(JudgeRows(model, left.cols));
  } else {
    for (const Question question : {Question::kTime, Question::kSides, Question::kRows}) {
      findings.push_back(CannotTell(question));
    }
  }
  findings.push_back(JudgeBits(left, right));
  findings.push_back(is_one_scene ? JudgeContrast(left, right, model)
                                  : CannotTell(Question::kContrast));
  return findings;
}

}  // namespace sprout::inputs
