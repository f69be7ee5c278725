#pragma once

#include "common/core/disparity_image.h"
#include "common/measure/score.h"
#include "common/scenes/dataset.h"
#include "services/pipeline/pipeline.h"

namespace sprout {

/// What the stages compute of a frame in one process, without any message, with preset default.
inline DisparityImage ComputeInProcess(const std::string& from, int64_t index) {
  SproutConfig config = LoadConfig({"default"});
  config.mutable_capture()->set_source(from);
  const auto source = scenes::OpenDataset(config.capture());
  const scenes::DatasetFrame captured = source->Get(index);
  return Pipeline(config)
      .Compute(captured.left, captured.right, captured.tof, source->rig())
      .value()
      .disparity;
}

/// Share of the pixels that both cameras see whose disparity is within 1 px of the truth.
inline double CorrectPercent(const DisparityImage& map, const scenes::GroundTruth& truth) {
  const auto mask = NonOccludedMask(truth.left, truth.right);
  return Score(map, truth.left, mask.value()).value().correct_le1_percent();
}

}  // namespace sprout
