#ifndef SPROUT_TESTS_SYSTEM_CORRECT_PERCENT_H_
#define SPROUT_TESTS_SYSTEM_CORRECT_PERCENT_H_

#include "common/core/disparity_image.h"
#include "common/measure/score.h"
#include "common/scenes/dataset.h"

namespace sprout {

/// Share of the pixels that both cameras see whose disparity is within 1 px of the truth.
inline double CorrectPercent(const DisparityImage& map, const scenes::GroundTruth& truth) {
  const auto mask = NonOccludedMask(truth.left, truth.right);
  return Score(map, truth.left, mask.value()).value().correct_le1_percent();
}

}  // namespace sprout

#endif  // SPROUT_TESTS_SYSTEM_CORRECT_PERCENT_H_
