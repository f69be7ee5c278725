#include "common/core/frame.h"

#include <utility>

namespace sprout {

void SetPart(Frame& frame, Part part, PartValue value) {
  switch (part) {
    case Part::kLeft:
      frame.left = std::get<cv::Mat>(std::move(value));
      return;
    case Part::kRight:
      frame.right = std::get<cv::Mat>(std::move(value));
      return;
    case Part::kTof:
      frame.tof = std::get<TofImage>(std::move(value));
      return;
    case Part::kRig:
      frame.rig = std::get<Rig>(std::move(value));
      return;
    case Part::kSeeds:
      frame.seeds = std::get<SeedSet>(std::move(value));
      return;
    case Part::kLeftSeeds:
      frame.left_seeds = std::get<SeedSet>(std::move(value));
      return;
    case Part::kPrior:
      frame.prior = std::get<DisparityImage>(std::move(value));
      return;
    case Part::kUnfilled:
      frame.unfilled = std::get<DisparityImage>(std::move(value));
      return;
    case Part::kDisparity:
      frame.disparity = std::get<DisparityImage>(std::move(value));
      return;
    case Part::kConfidence:
      frame.confidence = std::get<cv::Mat>(std::move(value));
      return;
  }
}

}  // namespace sprout
