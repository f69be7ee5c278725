#include "services/grow/grow_plug.h"

#include <string>
#include <utility>

#include "common/core/image.h"
#include "services/finish/confidence.h"
#include "services/finish/gap_filler.h"
#include "services/grow/harris_seeds.h"

namespace sprout::grow {

PartSet GrowPlug::Inputs() const {
  PartSet inputs{Part::kLeft, Part::kRight};
  if (config_.seeds() == GrowConfig::TOF) inputs.Add(Part::kSeeds);
  if (config_.similarity() == GrowConfig::EPC || config_.fill() == GrowConfig::PRIOR) {
    inputs.Add(Part::kPrior);
  }
  return inputs;
}

std::vector<Seed> GrowPlug::SeedsOf(const Frame& frame, const cv::Mat1b& left,
                                    const cv::Mat1b& right) const {
  if (config_.seeds() == GrowConfig::TOF) return frame.seeds->seeds;
  if (left.size() != right.size()) return {};  // the grower says what is wrong
  return MatchHarrisCorners(left, right, config_.harris());
}

GrowPlug::Growth GrowPlug::Grow(const Frame& frame) {
  const cv::Mat1b left = ToGrey(frame.left);
  const cv::Mat1b right = ToGrey(frame.right);
  const PriorMap prior = frame.prior.value_or(PriorMap());
  Growth growth;
  growth.seeds = SeedsOf(frame, left, right);
  growth.map = DisparityImage(left.size());
  Result<DisparityImage> grown = grower_.Compute(left, right, growth.seeds, prior);
  if (!grown) {
    growth.refused = true;
    growth.degenerate = grown.error().text;
    return growth;
  }
  growth.map = std::move(*grown);
  if (growth.seeds.empty()) {
    growth.degenerate = "no seeds to grow from";
  } else if (frame.prior && prior.disparity.CountValid() == 0) {
    growth.degenerate = "the prior is empty";
  } else if (growth.map.CountValid() == 0) {
    growth.degenerate = "nothing grew from " + std::to_string(growth.seeds.size()) + " seeds";
  }
  return growth;
}

Outcome GrowPlug::Finish(const Frame& frame, const Growth& growth) const {
  Outcome outcome{.outputs = {}, .degenerate = growth.degenerate};
  if (config_.publish_unfilled()) outcome.outputs.push_back({Part::kUnfilled, growth.map});
  // Images that do not fit together say nothing about the prior either.
  const auto fill = growth.refused ? GrowConfig::NONE : config_.fill();
  DisparityImage filled =
      FillGaps(growth.map, fill, frame.prior ? frame.prior->disparity : DisparityImage());
  cv::Mat1b confidence(filled.size(), uint8_t{0});
  if (config_.publish_confidence() || config_.min_confidence() > 0) {
    if (!growth.refused) {
      confidence = Confidence(ToGrey(frame.left), ToGrey(frame.right), growth.seeds, growth.map,
                              filled, config_.sigma_s_squared());
    }
    DropUnsure(confidence, config_.min_confidence(), filled);
  }
  outcome.outputs.push_back({Part::kDisparity, filled});
  if (config_.publish_confidence()) {
    outcome.outputs.push_back({Part::kConfidence, cv::Mat(confidence)});
  }
  return outcome;
}

}  // namespace sprout::grow
