#include "common/inputs/judge_sides.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "common/core/quantile.h"
#include "common/inputs/occlusion_order.h"

namespace sprout::inputs {
namespace {

struct SideRules {
  static constexpr double kBehindPx = 1;         ///< a match is beyond infinity by more
  static constexpr double kManyBehind = 0.9;     ///< share: of a swapped pair
  static constexpr double kSomeBehind = 0.15;    ///< principal points that do not fit
  static constexpr double kFewBehind = 0.05;     ///< false matches
  static constexpr double kFalseMatches = 0.02;  ///< share, of either end of the disparities
  static constexpr double kSureOrder = 2;        ///< standard deviations: 2.3 to 7 were seen
  /// The same picture twice: so many of the matches are at one place, to so many px, also where one
  /// of them was blurred or compressed to a tenth. Of a pair only what is thousands of baselines
  /// away is.
  static constexpr double kSamePx = 0.5;
  static constexpr double kSameShare = 0.9;
  /// Ranges speak for the order of the images with so many matches beside points, of which more
  /// than the first share agree; against it, where also less than the second agree as it is.
  static constexpr int kFewCompared = 25;
  static constexpr double kRangesAgree = 0.7;
  static constexpr double kRangesDisagree = 0.3;
  /// Ranges speak for columns that are moved alike by so many px at least (less may be the device's
  /// own error) with so many matches, of which so many are close, and surely fewer otherwise.
  static constexpr double kMinAsidePx = 4;
  static constexpr int kSomeCompared = 40;
  static constexpr double kMinClose = 0.7;
  static constexpr double kSureAside = 3;  ///< standard deviations
};

double ShareBehind(const std::vector<Match>& matches, double infinity_px, double sign) {
  const auto behind = std::ranges::count_if(matches, [&](const Match& match) {
    return sign * match.disparity() + infinity_px < -SideRules::kBehindPx;
  });
  return static_cast<double>(behind) / static_cast<double>(matches.size());
}

constexpr const char* kSwapped =
    "left and right are swapped: give them the other way round (or tell the columns of the "
    "principal points: cx, cx_right)";

// Where the principal points allow the disparities of either order.
void JudgeOrder(const cv::Mat1b& left, const cv::Mat1b& right, const PairModel& model,
                Finding& finding) {
  std::vector<double> disparities;
  for (const Match& match : model.inliers) disparities.push_back(match.disparity());
  const double least = Quantile(disparities, SideRules::kFalseMatches);
  const double most = Quantile(disparities, 1 - SideRules::kFalseMatches);
  const OcclusionOrder order = FindOcclusionOrder(left, right, least, most);
  if (order.sigmas < -SideRules::kSureOrder) {
    finding.verdict = Verdict::kBad;
    finding.text =
        fmt::format("{}: far things hide near ones, by {:.1f} σ", kSwapped, -order.sigmas);
  } else if (order.sigmas > SideRules::kSureOrder) {
    finding.verdict = Verdict::kGood;
    finding.text = fmt::format("near things hide far ones, by {:.1f} σ", order.sigmas);
  }
}

bool AreOnePicture(const std::vector<Match>& matches) {
  const auto same = std::ranges::count_if(matches, [](const Match& match) {
    return std::hypot(match.disparity(), match.rows()) < SideRules::kSamePx;
  });
  return static_cast<double>(same) >= SideRules::kSameShare * static_cast<double>(matches.size());
}

// Whether columns that are moved alike explain the ranges, and nothing else does, as a factor of
// the ranges before a flat wall.
bool AreColumnsAside(const RangeModel& ranges) {
  const Agreement& aside = ranges.aside;
  const auto explains_more_than = [&](const Agreement* other) {
    return other->close_share() < aside.close_share() / 2 ||
           MoreAgree(aside, *other, Vote::kIsClose) >= SideRules::kSureAside;
  };
  return aside.compared >= SideRules::kSomeCompared &&
         std::abs(aside.with.columns_px) >= SideRules::kMinAsidePx &&
         aside.close_share() >= SideRules::kMinClose &&
         std::ranges::all_of(
             std::array{&ranges.as_is, &ranges.scaled, &ranges.misread, &ranges.turned,
                        &ranges.moved, &ranges.shifted, &ranges.spread, &ranges.swapped},
             explains_more_than);
}

std::string AsideText(const RectifiedPair& pair, const RangeModel& ranges) {
  const Hypothesis& with = ranges.aside.with;
  const double columns_px = with.columns_px;
  const char* if_wrong = with.turn != Turn{} ? ", which are turned or mirrored, too"
                         : with.factor != 1  ? ", which are in another unit, too"
                                             : "";
  return fmt::format(
      "columns of the right image lie {:.1f} ± {:.2f} px further {} than ranges say{} "
      "(then {:.0f} % of these are within 1 % of stereo, as it is {:.0f} %): was an image cropped "
      "(cx_right {:.1f}, not {:.1f}), or is a camera turned?",
      std::abs(columns_px), MedianOf(ranges.aside.offs_px).sigma, columns_px < 0 ? "left" : "right",
      if_wrong, 100 * ranges.aside.close_share(), 100 * ranges.as_is.close_share(),
      pair.cx_right + columns_px, pair.cx_right);
}

}  // namespace

Finding JudgeSides(const cv::Mat1b& left, const cv::Mat1b& right, const RectifiedPair& pair,
                   const PairModel& model, const RangeModel* ranges) {
  Finding finding{.question = Question::kSides};
  std::vector<double> disparities;
  for (const Match& match : model.inliers) disparities.push_back(match.disparity());
  finding.near_px = Quantile(disparities, 0.9);
  const double infinity_px = pair.cx_right - pair.cx;
  const double behind = ShareBehind(model.inliers, infinity_px, 1);
  const double behind_if_swapped = ShareBehind(model.inliers, infinity_px, -1);
  finding.value = 100 * behind;
  finding.sigma =
      100 * std::sqrt(behind * (1 - behind) / static_cast<double>(model.inliers.size()));
  const auto agree = [](const Agreement& agreement) {
    return agreement.compared >= SideRules::kFewCompared &&
           agreement.share() > SideRules::kRangesAgree;
  };
  const bool ranges_agree = ranges != nullptr && agree(ranges->as_is);
  const bool ranges_say_swapped = ranges != nullptr && agree(ranges->swapped) &&
                                  ranges->as_is.share() < SideRules::kRangesDisagree;
  if (AreOnePicture(model.inliers)) {
    finding.verdict = Verdict::kBad;
    finding.text =
        "left and right are the same picture: is one file given twice, or is everything too far "
        "for this baseline?";
  } else if (ranges_say_swapped ||
             (behind > SideRules::kManyBehind && behind_if_swapped < SideRules::kFewBehind)) {
    finding.verdict = Verdict::kBad;
    finding.text = kSwapped;
  } else if (ranges != nullptr && AreColumnsAside(*ranges)) {
    finding.verdict = Verdict::kBad;
    finding.text = AsideText(pair, *ranges);
  } else if (behind > SideRules::kSomeBehind) {
    finding.verdict = Verdict::kBad;
    finding.text = fmt::format(
        "{:.0f} ± {:.0f} % of the matches lie beyond infinity: the columns of the principal points "
        "do not fit these images (cx, cx_right)",
        finding.value, finding.sigma);
  } else if (behind <= SideRules::kFewBehind &&
             (behind_if_swapped > SideRules::kSomeBehind || ranges_agree)) {
    finding.verdict = Verdict::kGood;
    finding.text = fmt::format("{:.0f} % of the matches lie beyond infinity", finding.value);
  } else {
    finding.text = fmt::format(
        "{:.0f} ± {:.0f} % of the matches lie beyond infinity, {:.0f} % would with left and right "
        "swapped: too alike to tell",
        finding.value, finding.sigma, 100 * behind_if_swapped);
    if (behind <= SideRules::kFewBehind) JudgeOrder(left, right, model, finding);
  }
  return finding;
}

}  // namespace sprout::inputs
