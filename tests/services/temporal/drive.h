#pragma once

#include <vector>

#include "common/config/config.h"
#include "services/temporal/temporal_filter.h"
#include "tests/services/temporal/moving_scene.h"

namespace sprout::temporal {

inline constexpr double kNoisePx = 0.4;

inline TemporalConfig Defaults() { return LoadConfig({}).temporal(); }

/// The camera comes nearer, to the right, and turns.
inline Pose PoseAt(int frame) {
  return MovedBy(0.012 * frame, -0.004 * frame, 0.03 * frame, 0.004 * frame);
}

inline std::vector<TemporalInput> Drive(int frames) {
  std::vector<TemporalInput> inputs;
  for (int i = 0; i < frames; ++i) {
    inputs.push_back(FrameFrom(SceneFrom(PoseAt(i)), i, kNoisePx));
  }
  return inputs;
}

/// What the filter makes of the last of them, after all others.
inline TemporalOutput LastOf(const std::vector<TemporalInput>& inputs) {
  TemporalFilter filter(Defaults());
  TemporalOutput output;
  for (const TemporalInput& input : inputs) output = filter.Compute(input);
  return output;
}

}  // namespace sprout::temporal
