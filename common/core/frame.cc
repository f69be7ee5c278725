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
      frame.prior = std::get<PriorMap>(std::move(value));
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

size_t BytesOf(const Frame& frame) {
  size_t bytes = 0;
  const auto add = [&](const cv::Mat& mat) { bytes += mat.total() * mat.elemSize(); };
  const auto add_map = [&](const auto& map) { add(map ? map->counts() : cv::Mat1s()); };
  const auto add_seeds = [&](const auto& set) {
    bytes += set ? set->seeds.capacity() * sizeof(Seed) : 0;
  };
  add(frame.left);
  add(frame.right);
  add(frame.tof ? frame.tof->depth_m : cv::Mat1f());
  add(frame.tof ? frame.tof->amplitude : cv::Mat1f());
  add_seeds(frame.seeds);
  add_seeds(frame.left_seeds);
  add(frame.prior ? frame.prior->disparity.counts() : cv::Mat1s());
  add(frame.prior ? frame.prior->sigma : cv::Mat1b());
  add_map(frame.unfilled);
  add_map(frame.disparity);
  add(frame.confidence);
  return bytes;
}

std::optional<cv::Size> ImageSize(const Frame& frame) {
  for (const cv::Mat* image : {&frame.left, &frame.right, &frame.confidence}) {
    if (!image->empty()) return image->size();
  }
  if (frame.prior) return frame.prior->size();
  for (const auto* map : {&frame.unfilled, &frame.disparity}) {
    if (*map) return (*map)->size();
  }
  return std::nullopt;
}

}  // namespace sprout
