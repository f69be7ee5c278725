#include "services/grow/grow_adapter.h"

#include <algorithm>
#include <utility>

#include "common/core/answer_values.h"
#include "common/core/image.h"
#include "common/geometry/widened_frame.h"

namespace sprout::grow {

GrowAdapter::Growth GrowAdapter::Grow(const Frame& frame) {
  const int columns = ColumnsBelowZero(frame.seeds->seeds);
  if (columns == 0) {
    Growth growth = GrowFrom0(frame);
    if (frame.prior && !growth.map.AnyValid()) {
      // Other programs make priors, too.
      const auto wrong = WrongDisparity(frame.prior->disparity, /*least_px=*/-1);
      if (wrong) growth.degenerate += "; prior: " + *wrong;
    }
    return growth;
  }
  Frame wide = Widened(frame, columns);
  Growth growth = GrowFrom0(wide);
  growth.columns = columns;
  growth.wide = std::move(wide);
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
  // Where nothing grew the pair shows nothing; of its own seeds not even one was confirmed.
  const bool has_ranges = std::ranges::any_of(
      growth.seeds, [](const Seed& seed) { return seed.origin == SeedOrigin::kTof; });
  if (growth.refused || (!growth.map.AnyValid() && !has_ranges)) {
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
