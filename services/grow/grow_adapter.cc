#include "services/grow/grow_adapter.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "common/core/image.h"
#include "common/core/joined.h"
#include "common/core/window_sums.h"
#include "common/geometry/widened_frame.h"
#include "services/grow/confidence/row_check.h"

namespace sprout::grow {
namespace {

// Says that the prior is not that of the seeds, but of another scale or sign; else empty. Of
// Sprout's own priors at most 8 % of the seeds are so far away, in 271 frames with good and wrong
// ranges.
std::string ContradictionText(std::span<const Seed> seeds, const PriorMap& prior) {
  constexpr double kMinPx = 2;
  constexpr double kSigmas = 4;
  constexpr size_t kOneIn = 4;
  size_t contradicted = 0;
  std::string first;
  for (const Seed& seed : seeds) {
    const cv::Point at(cvRound(seed.u), cvRound(seed.v));
    if (!cv::Rect({}, prior.size()).contains(at) || !prior.disparity.IsValid(at.x, at.y)) continue;
    const double px = prior.disparity.Px(at.x, at.y);
    const double limit_px = std::max(kMinPx, kSigmas * SigmaToPx(prior.sigma(at)));
    if (std::abs(px - seed.disparity()) <= limit_px) continue;
    if (contradicted++ == 0) {
      first = cv::format("%g px at (%d, %d), the seed %g", px, at.x, at.y, seed.disparity());
    }
  }
  if (contradicted * kOneIn <= seeds.size()) return "";
  return "the prior contradicts " + std::to_string(contradicted) + " of " +
         std::to_string(seeds.size()) + " seeds: it has " + first;
}

// Says that the images do not show the seeds, as those of another program in another unit; else
// empty. Then fewer of the seeds with texture match better, by eq. (1), than 3 px nearer and
// farther, than chance would give: in 100 frames, by sums of absolute differences, 9 to 31 % where
// all are wrong by a factor or 5 px, and at least 54 % of right ones.
std::string MismatchText(const cv::Mat1b& left, const cv::Mat1b& right,
                         std::span<const Seed> seeds) {
  constexpr int kStepPx = 3;
  constexpr int kRadius = 2;
  constexpr double kMargin = kRadius - 0.5;
  constexpr int kPixels = (2 * kRadius + 1) * (2 * kRadius + 1);
  constexpr int kMinSigma = 4;  // of a window with texture, grey levels
  constexpr size_t kEnough = 1000;
  int textured = 0;
  int matched = 0;
  for (size_t i = 0; i < seeds.size(); i += 1 + seeds.size() / kEnough) {
    const Seed& seed = seeds[i];
    if (!IsInside(seed.u, seed.v, left.size(), kMargin) ||
        !IsInside(seed.u_right, seed.v, right.size(), kMargin + kStepPx, kMargin)) {
      continue;
    }
    const cv::Point at(cvRound(seed.u), cvRound(seed.v));
    int variance = 0;
    const auto mncc = [&](int aside_px) {
      const WindowSums sums =
          SumWindows<kRadius>(left, right, at, {cvRound(seed.u_right) + aside_px, at.y});
      variance = kPixels * sums.left_squares - sums.left * sums.left;
      const int of_right = kPixels * sums.right_squares - sums.right * sums.right;
      const int both = kPixels * sums.products - sums.left * sums.right;
      return variance == 0 ? 0 : 2.0 * both / (variance + of_right);
    };
    const double here = mncc(0);
    if (variance < kPixels * kPixels * kMinSigma * kMinSigma) continue;
    ++textured;
    matched += here > std::max(mncc(-kStepPx), mncc(kStepPx)) ? 1 : 0;
  }
  // Three standard deviations below one in three.
  if (matched >= textured / 3.0 - std::sqrt(2.0 * textured)) return "";
  return cv::format(
      "%d of %d seeds with texture match the images better than 3 px beside them, "
      "fewer than by chance: are they of this pair and moment, and in px?",
      matched, textured);
}

}  // namespace

GrowAdapter::Growth GrowAdapter::Grow(const Frame& frame) {
  Growth growth;
  if (const int columns = ColumnsBelowZero(frame.seeds->seeds); columns == 0) {
    growth = GrowNonNegative(frame);
  } else {
    Frame wide = Widened(frame, columns);
    growth = GrowNonNegative(wide);
    growth.columns = columns;
    growth.wide = std::move(wide);
  }
  if (!frame.prior || frame.prior->size() != frame.left.size()) return growth;
  const std::string contradiction = ContradictionText(frame.seeds->seeds, *frame.prior);
  growth.contradicted = !contradiction.empty();
  growth.degenerate = JoinedTexts(growth.degenerate, contradiction);
  return growth;
}

GrowAdapter::Growth GrowAdapter::GrowNonNegative(const Frame& frame) {
  const cv::Mat1b left = ToGrey(GreyestLeft(frame), left_grey_);
  const cv::Mat1b right = ToGrey(GreyestRight(frame), right_grey_);
  const PriorMap prior = frame.prior.value_or(PriorMap());
  Growth growth;
  growth.seeds = frame.seeds->seeds;
  Result<DisparityImage> grown = grower_.Compute(left, right, growth.seeds, prior);
  if (!grown) {
    growth.is_unfit = true;
    growth.map = DisparityImage(left.size());
    growth.degenerate = grown.error().text;
    return growth;
  }
  growth.map = std::move(*grown);
  if (growth.seeds.empty()) {
    growth.degenerate = "no seeds to grow from";
  } else if (frame.prior && prior.size() != left.size()) {
    growth.degenerate = "a prior of " + SizeText(prior.size()) + ": allowed is the images' size " +
                        SizeText(left.size());
  } else if (frame.prior && !prior.disparity.AnyValid()) {
    growth.degenerate = "the prior is empty";
  } else if (!growth.map.AnyValid()) {
    growth.degenerate = "nothing grew from " + std::to_string(growth.seeds.size()) + " seeds";
  }
  growth.degenerate = JoinedTexts(growth.degenerate, MismatchText(left, right, growth.seeds));
  return growth;
}

// @param doubt  gets what is wrong with the pair if that bounds the confidence; else empty.
ConfidenceEstimator::Judgement GrowAdapter::Judge(const Frame& frame, const Growth& growth,
                                                  const DisparityImage& filled,
                                                  std::string& doubt) {
  // Nothing is sure where the pair has confirmed none of its own seeds, or the prior is wrong: then
  // growth finds what resembles it.
  const bool has_ranges = std::ranges::any_of(
      growth.seeds, [](const Seed& seed) { return seed.origin == SeedOrigin::kTof; });
  if (growth.is_unfit || growth.contradicted || (!growth.map.AnyValid() && !has_ranges)) {
    return {cv::Mat1b(filled.size(), uint8_t{0}), cv::Mat1b(filled.size(), kMaxSigmaCounts)};
  }
  const cv::Mat1b left = ToGrey(GreyestLeft(frame), left_grey_);
  const cv::Mat1b right = ToGrey(GreyestRight(frame), right_grey_);
  const bool has_prior = frame.prior && frame.prior->sigma.size() == filled.size();
  const cv::Mat1b sigma_prior = has_prior ? frame.prior->sigma : cv::Mat1b();
  const JudgedFrame judged{left, right, growth.seeds, sigma_prior, growth.map, filled};
  ConfidenceEstimator::Judgement judgement = confidence_.Compute(judged);
  doubt = BoundByRows(judged, judgement);
  return judgement;
}

StageResult GrowAdapter::Finish(const Frame& frame, const Growth& growth) {
  if (growth.columns == 0) return FinishNonNegative(frame, growth);
  StageResult result = FinishNonNegative(growth.wide, growth);
  Narrow(result, growth.columns, frame.left.size());
  return result;
}

StageResult GrowAdapter::FinishNonNegative(const Frame& frame, const Growth& growth) {
  StageResult outcome{.outputs = {}, .degenerate = growth.degenerate};
  if (config_.publish_unfilled()) outcome.outputs.push_back({Part::kUnfilled, growth.map});
  // Images that do not fit together say nothing about the prior either.
  const auto fill = growth.is_unfit ? GrowConfig::NONE : config_.fill();
  DisparityImage filled =
      gap_filler_.Fill(growth.map, fill, frame.prior ? frame.prior->disparity : DisparityImage());
  ConfidenceEstimator::Judgement judgement;
  if (config_.publish_confidence() || config_.min_confidence() > 0) {
    std::string doubt;
    judgement = Judge(frame, growth, filled, doubt);
    outcome.degenerate = JoinedTexts(outcome.degenerate, doubt);
    DropUnsure(judgement.confidence, config_.min_confidence(), filled);
  }
  outcome.outputs.push_back({Part::kDisparity, filled});
  if (config_.publish_confidence()) {
    outcome.outputs.push_back({Part::kConfidence, cv::Mat(judgement.confidence)});
    outcome.outputs.push_back({Part::kSigma, cv::Mat(judgement.sigma)});
  }
  return outcome;
}

}  // namespace sprout::grow
