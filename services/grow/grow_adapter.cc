#include "services/grow/grow_adapter.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "common/core/image.h"
#include "common/geometry/widened_frame.h"

namespace sprout::grow {
namespace {

// What says that the prior is not that of the seeds, but of another scale or sign; else empty. Of
// Sprout's own priors at most 8 % of the seeds are so far away, in 271 frames with good and wrong
// ranges.
std::string Contradiction(std::span<const Seed> seeds, const PriorMap& prior) {
  constexpr double kLeastPx = 2;
  constexpr double kSigmas = 4;
  constexpr size_t kOneIn = 4;
  size_t contradicted = 0;
  std::string first;
  for (const Seed& seed : seeds) {
    const cv::Point at(cvRound(seed.u), cvRound(seed.v));
    if (!cv::Rect({}, prior.size()).contains(at) || !prior.disparity.IsValid(at.x, at.y)) continue;
    const double px = prior.disparity.Px(at.x, at.y);
    const double limit_px = std::max(kLeastPx, kSigmas * SigmaToPx(prior.sigma(at)));
    if (std::abs(px - seed.disparity()) <= limit_px) continue;
    if (contradicted++ == 0) {
      first = cv::format("%g px at (%d, %d), the seed %g", px, at.x, at.y, seed.disparity());
    }
  }
  if (contradicted * kOneIn <= seeds.size()) return "";
  return "the prior contradicts " + std::to_string(contradicted) + " of " +
         std::to_string(seeds.size()) + " seeds: it has " + first;
}

}  // namespace

GrowAdapter::Growth GrowAdapter::Grow(const Frame& frame) {
  Growth growth;
  if (const int columns = ColumnsBelowZero(frame.seeds->seeds); columns == 0) {
    growth = GrowFrom0(frame);
  } else {
    Frame wide = Widened(frame, columns);
    growth = GrowFrom0(wide);
    growth.columns = columns;
    growth.wide = std::move(wide);
  }
  if (!frame.prior || frame.prior->size() != frame.left.size()) return growth;
  const std::string contradiction = Contradiction(frame.seeds->seeds, *frame.prior);
  growth.contradicted = !contradiction.empty();
  if (growth.contradicted && !growth.degenerate.empty()) growth.degenerate += "; ";
  growth.degenerate += contradiction;
  return growth;
}

GrowAdapter::Growth GrowAdapter::GrowFrom0(const Frame& frame) {
  const cv::Mat1b left = ToGrey(GreyestLeft(frame), left_grey_);
  const cv::Mat1b right = ToGrey(GreyestRight(frame), right_grey_);
  const PriorMap prior = frame.prior.value_or(PriorMap());
  Growth growth;
  growth.seeds = frame.seeds->seeds;
  Result<DisparityImage> grown = grower_.Compute(left, right, growth.seeds, prior);
  if (!grown) {
    growth.refused = true;
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
  return growth;
}

ConfidenceEstimator::Judgement GrowAdapter::Judge(const Frame& frame, const Growth& growth,
                                                  const DisparityImage& filled) {
  // Where nothing grew the pair shows nothing; of its own seeds not even one was confirmed. Beside
  // a wrong prior growth finds what looks like it.
  const bool has_ranges = std::ranges::any_of(
      growth.seeds, [](const Seed& seed) { return seed.origin == SeedOrigin::kTof; });
  if (growth.refused || growth.contradicted || (!growth.map.AnyValid() && !has_ranges)) {
    return {cv::Mat1b(filled.size(), uint8_t{0}), cv::Mat1b(filled.size(), kMaxSigmaCounts)};
  }
  const cv::Mat1b left = ToGrey(GreyestLeft(frame), left_grey_);
  const cv::Mat1b right = ToGrey(GreyestRight(frame), right_grey_);
  const bool has_prior = frame.prior && frame.prior->sigma.size() == filled.size();
  const cv::Mat1b sigma_prior = has_prior ? frame.prior->sigma : cv::Mat1b();
  return confidence_.Compute({left, right, growth.seeds, sigma_prior, growth.map, filled});
}

StageResult GrowAdapter::Finish(const Frame& frame, const Growth& growth) {
  if (growth.columns == 0) return FinishFrom0(frame, growth);
  StageResult result = FinishFrom0(growth.wide, growth);
  Narrow(result, growth.columns, frame.left.size());
  return result;
}

StageResult GrowAdapter::FinishFrom0(const Frame& frame, const Growth& growth) {
  StageResult outcome{.outputs = {}, .degenerate = growth.degenerate};
  if (config_.publish_unfilled()) outcome.outputs.push_back({Part::kUnfilled, growth.map});
  // Images that do not fit together say nothing about the prior either.
  const auto fill = growth.refused ? GrowConfig::NONE : config_.fill();
  DisparityImage filled =
      gap_filler_.Fill(growth.map, fill, frame.prior ? frame.prior->disparity : DisparityImage());
  ConfidenceEstimator::Judgement judgement;
  if (config_.publish_confidence() || config_.min_confidence() > 0) {
    judgement = Judge(frame, growth, filled);
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
