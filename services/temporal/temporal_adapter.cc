#include "services/temporal/temporal_adapter.h"

#include <string>
#include <utility>

#include "common/core/image.h"

namespace sprout::temporal {
namespace {

std::string SizeProblem(const Frame& frame) {
  const cv::Size size = frame.rig->pair.size();
  const std::pair<const char*, cv::Size> parts[] = {{"LEFT", frame.left.size()},
                                                    {"DISPARITY", frame.disparity->size()},
                                                    {"CONFIDENCE", frame.confidence.size()}};
  for (const auto& [name, its_size] : parts) {
    if (its_size != size) {
      return std::string(name) + " of " + SizeText(its_size) + ": allowed is the calibrated size " +
             SizeText(size);
    }
  }
  return frame.confidence.channels() == 1 ? "" : "CONFIDENCE in colour: allowed is grey";
}

// The answer to a frame that cannot be used: maps of LEFT's size without a disparity, no motion.
StageResult Unusable(const Frame& frame, std::string reason, int64_t resets) {
  CameraMotion motion;
  motion.reset = MemoryReset::kOtherRig;
  motion.resets = resets;
  motion.last_seq = motion.start_seq = frame.id.seq;
  return {.outputs = {{Part::kFused, DisparityImage(frame.left.size())},
                      {Part::kFusedConfidence, cv::Mat(frame.left.size(), CV_8UC1, cv::Scalar(0))},
                      {Part::kMotion, motion}},
          .degenerate = std::move(reason)};
}

// Why the memory was lost, as people read it; empty if it was not, or for the first frame.
std::string ReasonText(const CameraMotion& motion, TemporalConfig::Motion source) {
  const std::string points =
      std::to_string(motion.inliers) + " of " + std::to_string(motion.tracked) + " points";
  switch (motion.reset) {
    case MemoryReset::kNone:
    case MemoryReset::kFirst:
      return "";
    case MemoryReset::kOtherRig:
      return "earlier frames forgotten: another rig or image size";
    case MemoryReset::kBackwards:
      return "earlier frames forgotten: seq or time went back";
    case MemoryReset::kGap:
      return "earlier frames forgotten: too long since the last one";
    case MemoryReset::kFewPoints:
      if (source == TemporalConfig::CHANNEL) {
        return "earlier frames forgotten: SPROUT_ODOMETRY has no pose in the frame of the last one";
      }
      return "earlier frames forgotten: only " + std::to_string(motion.tracked) +
             " points could be tracked";
    case MemoryReset::kNoAgreement:
      if (source == TemporalConfig::CHANNEL) {
        return "earlier frames forgotten: the poses on SPROUT_ODOMETRY lie too far apart";
      }
      return "earlier frames forgotten: only " + points + " move as one";
  }
  return "";
}

}  // namespace

StageResult TemporalAdapter::Process(const Frame& frame) {
  if (std::string problem = SizeProblem(frame); !problem.empty()) {
    return Unusable(frame, std::move(problem), filter_.resets());
  }
  // A copy: the filter keeps it, and the caller may use the frame's pixels again.
  const cv::Mat& left = GreyestLeft(frame);
  cv::Mat1b grey;
  if (left.channels() == 1) {
    left.copyTo(grey);
  } else {
    grey = ToGrey(left, grey);
  }
  TemporalOutput output = filter_.Compute({.id = frame.id,
                                           .left = grey,
                                           .disparity = *frame.disparity,
                                           .confidence = frame.confidence,
                                           .pair = frame.rig->pair,
                                           .odometry = frame.odometry});
  StageResult result{.outputs = {}, .degenerate = ReasonText(output.motion, config_.motion())};
  result.outputs.push_back({Part::kFused, std::move(output.disparity)});
  result.outputs.push_back({Part::kFusedConfidence, cv::Mat(output.confidence)});
  result.outputs.push_back({Part::kMotion, output.motion});
  return result;
}

}  // namespace sprout::temporal
