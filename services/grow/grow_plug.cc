#include "services/grow/grow_plug.h"

#include <string>
#include <utility>

#include "common/core/image.h"
#include "services/finish/confidence.h"
#include "services/finish/gap_filler.h"
#include "services/grow/harris_seeds.h"

namespace sprout {

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

Outcome GrowPlug::Process(const Frame& frame) {
  const cv::Mat1b left = ToGrey(frame.left);
  const cv::Mat1b right = ToGrey(frame.right);
  const PriorMap prior = frame.prior.value_or(PriorMap());
  const std::vector<Seed> seeds = SeedsOf(frame, left, right);
  Result<DisparityImage> grown = grower_.Compute(left, right, seeds, prior);

  Outcome outcome;
  GrowConfig::Fill fill = config_.fill();
  if (!grown) {
    outcome.degenerate = grown.error().text;
    grown = DisparityImage(left.size());
    fill = GrowConfig::NONE;  // images that do not fit together say nothing about the prior either
  } else if (seeds.empty()) {
    outcome.degenerate = "no seeds to grow from";
  } else if (frame.prior && prior.disparity.CountValid() == 0) {
    outcome.degenerate = "the prior is empty";
  } else if (grown->CountValid() == 0) {
    outcome.degenerate = "nothing grew from " + std::to_string(seeds.size()) + " seeds";
  }
  if (config_.publish_unfilled()) outcome.outputs.push_back({Part::kUnfilled, *grown});
  DisparityImage filled = FillGaps(*grown, fill, prior.disparity);
  cv::Mat1b confidence;
  if (config_.publish_confidence() || config_.min_confidence() > 0) {
    confidence = left.size() == right.size()
                     ? Confidence(left, right, seeds, *grown, filled, config_.sigma_s_squared())
                     : cv::Mat1b(left.size(), uint8_t{0});
    DropUnsure(confidence, config_.min_confidence(), filled);
  }
  outcome.outputs.push_back({Part::kDisparity, filled});
  if (config_.publish_confidence())
    outcome.outputs.push_back({Part::kConfidence, cv::Mat(confidence)});
  return outcome;
}

}  // namespace sprout
