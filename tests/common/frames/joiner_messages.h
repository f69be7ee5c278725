#pragma once

#include <string>
#include <vector>

#include "common/frames/frame_joiner.h"
#include "tests/common/core/even_prior.h"

// Short names for what the joiner is fed with.
namespace sprout {

/// Frame `seq` of a stream that captures every 100 ms.
inline FrameId IdOf(int64_t seq, const std::string& rig_id = "rig") {
  return {.utime = 1'000'000 + 100'000 * seq, .seq = seq, .rig_id = rig_id};
}

/// A part whose content shows what it was made from.
inline PartValue ValueOf(Part part, int mark) {
  const PartMember member = RowOf(part).member;
  if (std::holds_alternative<cv::Mat Frame::*>(member)) {
    return cv::Mat(1, 1, CV_8UC1, cv::Scalar(mark));
  }
  if (part == Part::kTof) {
    return TofImage{.depth_m = cv::Mat1f(1, 1, static_cast<float>(mark)), .amplitude = {}};
  }
  if (part == Part::kRig) {
    Rig rig;
    rig.pair.width = mark;
    return rig;
  }
  if (std::holds_alternative<std::optional<SeedSet> Frame::*>(member)) {
    return SeedSet{.seeds = {}, .raw = mark};
  }
  if (part == Part::kDepth || part == Part::kDepthSigma || part == Part::kTargetDepth) {
    return DepthImage{.counts = cv::Mat1w(1, 1, static_cast<uint16_t>(mark))};
  }
  if (std::holds_alternative<std::optional<PointCloud> Frame::*>(member)) return PointCloud{};
  if (part == Part::kDepthCounts) return DepthCounts{.pixels = mark};
  if (part == Part::kMotion || part == Part::kOdometry) return CameraMotion{};
  if (part == Part::kTofZones) return TofZones{};
  const DisparityImage map(cv::Mat1s(1, 1, static_cast<int16_t>(mark)));
  if (part == Part::kPrior) return EvenPrior(map, 1);
  return map;
}

/// Adds a part; returns the numbers of the frames that are complete now.
inline std::vector<int64_t> AddTo(FrameJoiner& joiner, const FrameId& id, Part part, int mark = 1) {
  std::vector<int64_t> seqs;
  for (const Frame& frame : joiner.Add(id, part, ValueOf(part, mark))) {
    seqs.push_back(frame.id.seq);
  }
  return seqs;
}

using Seqs = std::vector<int64_t>;

}  // namespace sprout
