#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/core/image.h"
#include "common/core/quantile.h"
#include "common/inputs/judges.h"

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

// --- What hides what ---

struct OrderRules {
  static constexpr double kMaxPixels = 200e3;  ///< of the level that is matched
  static constexpr int kMarginPx = 8;          ///< searched beyond the disparities that are known
  static constexpr float kMinStepPx = 3;       ///< of disparity at an edge
  static constexpr float kSteadyPx = 2;        ///< spread of disparity beside it
  static constexpr int kSteadyColumns = 6;
  static constexpr int kAround = 4;        ///< columns on either side of a strip
  static constexpr double kContrast = 6;   ///< grey levels between its two sides
  static constexpr int kRowsOfAnEdge = 8;  ///< rows that count as one observation
};

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

// Disparities of `left`, NaN where there is none.
cv::Mat1f Disparities(const cv::Mat1b& left, const cv::Mat1b& right, int least, int count) {
  const int border = std::max(std::abs(least), std::abs(least + count)) + 8;
  const auto widened = [&](const cv::Mat1b& image) {
    cv::Mat1b wide;
    cv::copyMakeBorder(image, wide, 0, 0, border, border, cv::BORDER_REPLICATE);
    return wide;
  };
  constexpr int kBlock = 5;
  const auto matcher =
      cv::StereoSGBM::create(least, count, kBlock, 8 * kBlock * kBlock, 32 * kBlock * kBlock, 0, 0,
                             10, 0, 0, cv::StereoSGBM::MODE_SGBM_3WAY);
  cv::Mat1s sixteenths;
  matcher->compute(widened(left), widened(right), sixteenths);
  cv::Mat1f disparities;
  sixteenths.colRange(border, border + left.cols).convertTo(disparities, CV_32F, 1.0 / 16);
  disparities.setTo(kNone, disparities < least);
  return disparities;
}

// The image with the brightness and contrast of the other one, since matches compare grey values.
cv::Mat1b Alike(const cv::Mat1b& image, const cv::Mat1b& other) {
  cv::Scalar mean, sigma, other_mean, other_sigma;
  cv::meanStdDev(image, mean, sigma);
  cv::meanStdDev(other, other_mean, other_sigma);
  const double gain = other_sigma[0] / std::max(1.0, sigma[0]);
  cv::Mat1b alike;
  image.convertTo(alike, CV_8U, gain, other_mean[0] - gain * mean[0]);
  return alike;
}

cv::Mat1b Mirrored(const cv::Mat1b& image) {
  cv::Mat1b mirrored;
  cv::flip(image, mirrored, 1);
  return mirrored;
}

struct View {
  cv::Mat1b image;
  cv::Mat1f disparity;  // where both images agree to a pixel; else NaN
};

View Agreed(const cv::Mat1b& image, const cv::Mat1f& own, const cv::Mat1f& of_other) {
  View view = {image, own.clone()};
  for (int v = 0; v < own.rows; ++v) {
    for (int u = 0; u < own.cols; ++u) {
      float& d = view.disparity(v, u);
      if (std::isnan(d)) continue;
      // The other map is mirrored.
      const int other = own.cols - 1 - static_cast<int>(std::lround(static_cast<float>(u) - d));
      if (other < 0 || other >= own.cols || !(std::abs(of_other(v, other) - d) <= 1)) d = kNone;
    }
  }
  return view;
}

bool IsSteady(const float* begin) {
  int known = 0;
  float least = std::numeric_limits<float>::max(), most = std::numeric_limits<float>::lowest();
  for (int i = 0; i < OrderRules::kSteadyColumns; ++i) {
    if (std::isnan(begin[i])) continue;
    ++known;
    least = std::min(least, begin[i]);
    most = std::max(most, begin[i]);
  }
  return known >= OrderRules::kSteadyColumns - 1 && most - least <= OrderRules::kSteadyPx;
}

// Where brightness changes most between two columns: the two parts with the least variance in
// themselves (Otsu's criterion). Nothing where they are too alike.
std::optional<double> ChangeIn(const std::vector<double>& row, int begin, int end) {
  const int count = end - begin;
  double all = 0;
  for (int u = begin; u < end; ++u) all += row[static_cast<size_t>(u)];
  double before = 0, best = 0;
  std::optional<double> place;
  for (int k = 1; k < count - 2; ++k) {
    before += row[static_cast<size_t>(begin + k - 1)];
    if (k < 3) continue;
    const double step = before / k - (all - before) / (count - k);
    const double between = step * step * k * (count - k) / count;
    if (between > best) {
      best = between;
      place = begin + k - 0.5;
    }
  }
  const bool clear = best >= OrderRules::kContrast * OrderRules::kContrast * count / 6;
  return clear ? place : std::nullopt;
}

struct Votes {
  double sum = 0;
  double squares = 0;  // of the sums of kRowsOfAnEdge rows
};

// Where disparity rises from one column to the next, a strip of as many columns of this image is
// hidden in the other one.
void AddRow(const View& view, int v, double& sum) {
  const float* d = view.disparity[v];
  const int width = view.disparity.cols;
  std::vector<double> row(static_cast<size_t>(width));
  for (int u = 0; u < width; ++u) {
    row[static_cast<size_t>(u)] =
        (view.image(v - 1, u) + view.image(v, u) + view.image(v + 1, u)) / 3.0;
  }
  int last = -1;
  for (int u = 0; u < width; ++u) {
    if (std::isnan(d[u])) continue;
    const int before = last;
    last = u;
    if (before < OrderRules::kSteadyColumns || u > width - 1 - OrderRules::kSteadyColumns) continue;
    const float step = d[u] - d[before];
    if (step < OrderRules::kMinStepPx ||
        std::abs(static_cast<float>(u - before - 1) - step) > step / 2 + 2 ||
        !IsSteady(d + before + 1 - OrderRules::kSteadyColumns) || !IsSteady(d + u)) {
      continue;
    }
    const auto change = ChangeIn(row, before - OrderRules::kAround, u + OrderRules::kAround + 1);
    if (!change) continue;
    const double half = std::max(1.0, (u - before) / 2.0);
    sum += std::clamp((*change - (u + before) / 2.0) / half, -1.0, 1.0);
  }
}

void AddView(const View& view, Votes& votes) {
  double sum = 0;
  for (int v = 1; v + 1 < view.image.rows; ++v) {
    AddRow(view, v, sum);
    if (v % OrderRules::kRowsOfAnEdge != 0 && v + 2 < view.image.rows) continue;
    votes.sum += sum;
    votes.squares += sum * sum;
    sum = 0;
  }
}

// Whether what occludes has the larger disparity, as it must: the strip beside a depth edge that
// only one image shows belongs to the farther surface. Where left and right are swapped (or both
// images mirrored) all disparities are negated, and it seems to belong to the nearer one.
// Semi-global matching (OpenCV's) of a level of at most 0.2 MP, from either image; about 50 ms.
// @param least_px, most_px  disparities, least < most.
// @returns standard deviations; < 0: it has the smaller one; 0 without an edge.
double OcclusionOrder(const cv::Mat1b& left, const cv::Mat1b& right, double least_px,
                      double most_px) {
  cv::Mat1b small_left = left, small_right = right;
  double shrink = 1;
  while (static_cast<double>(small_left.total()) > OrderRules::kMaxPixels) {
    small_left = Halved(small_left);
    small_right = Halved(small_right);
    shrink *= 2;
  }
  small_right = Alike(small_right, small_left);
  const int least = static_cast<int>(std::floor(least_px / shrink)) - OrderRules::kMarginPx;
  const int most = static_cast<int>(std::ceil(most_px / shrink)) + OrderRules::kMarginPx;
  const int count = (most - least + 15) / 16 * 16;  // StereoSGBM takes multiples of 16
  // In a mirror the right image is the left one of the pair.
  const cv::Mat1b mirrored_left = Mirrored(small_left);
  const cv::Mat1b mirrored_right = Mirrored(small_right);
  const cv::Mat1f of_left = Disparities(small_left, small_right, least, count);
  const cv::Mat1f of_right = Disparities(mirrored_right, mirrored_left, least, count);
  Votes votes;
  AddView(Agreed(small_left, of_left, of_right), votes);
  AddView(Agreed(mirrored_right, of_right, of_left), votes);
  return votes.squares > 0 ? votes.sum / std::sqrt(votes.squares) : 0;
}

// --- The order of the images ---

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
  const double sigmas = OcclusionOrder(left, right, least, most);
  if (sigmas < -SideRules::kSureOrder) {
    finding.verdict = Verdict::kBad;
    finding.text = fmt::format("{}: far things hide near ones, by {:.1f} σ", kSwapped, -sigmas);
  } else if (sigmas > SideRules::kSureOrder) {
    finding.verdict = Verdict::kGood;
    finding.text = fmt::format("near things hide far ones, by {:.1f} σ", sigmas);
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
