#pragma once

#include <chrono>
#include <opencv2/core.hpp>
#include <vector>

#include "common/bus/channels.h"
#include "common/messages/codec.h"
#include "services/view/frame_ring.h"
#include "tests/common/core/centred.h"

namespace sprout::view {

inline const cv::Size kViewSize{64, 48};

inline FrameId ViewId(int64_t seq) { return {1'000'000 + 100'000 * seq, seq, "rig"}; }

inline std::vector<uint8_t> Encoded(int64_t seq, Part part, const PartValue& value) {
  return EncodePart(ViewId(seq), part, value);
}

inline Rig ViewRig() { return {CentredPair(kViewSize.width, kViewSize.height, 50), {}}; }

inline cv::Mat ViewImage(int grey) { return cv::Mat(kViewSize, CV_8UC1, cv::Scalar(grey)); }

/// A map whose columns rise from 0 px, without a disparity in the first one.
inline DisparityImage ViewMap() {
  DisparityImage map(kViewSize);
  for (int v = 0; v < map.height(); ++v) {
    for (int u = 1; u < map.width(); ++u) map.counts()(v, u) = ToCounts(u / 4.0);
  }
  return map;
}

/// A ring with its own clock.
struct RingInput {
  explicit RingInput(size_t max_bytes = size_t{64} << 20) : ring(max_bytes) {}

  /// @returns whether there is something new to look at.
  bool Add(int64_t seq, Part part, const PartValue& value) {
    return *ring.Add(ChannelOf(part), Encoded(seq, part, value), utime, now);
  }

  void Wait(std::chrono::milliseconds time) {
    now += time;
    utime += std::chrono::microseconds(time).count();
  }

  FrameRing ring;
  FrameRing::Clock::time_point now{std::chrono::hours(1)};
  int64_t utime = 1'000'000;
};

inline void AddWhole(RingInput& input, int64_t seq) {
  input.Add(seq, Part::kRig, ViewRig());
  input.Add(seq, Part::kLeft, ViewImage(static_cast<int>(seq % 256)));
  input.Add(seq, Part::kSeeds, SeedSet{.seeds = {{.u = 10, .v = 20, .u_right = 7.5}}, .raw = 1});
  input.Add(seq, Part::kDisparity, ViewMap());
}

}  // namespace sprout::view
