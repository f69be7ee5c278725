#include <opencv2/calib3d.hpp>

#include "common/core/image.h"
#include "services/tools/evaluate/rivals/padded_pair.h"
#include "services/tools/evaluate/rivals/rival.h"

namespace sprout::evaluate {
namespace {

// Parameters as OpenCV's documentation advises: penalties of 8 and 32 times the block's area.
cv::Mat1f Sgbm(const RivalInput& input, int mode) {
  constexpr int kBlock = 5;
  constexpr int kFirstDisparity = 0;
  constexpr int kSmallStepPenalty = 8 * kBlock * kBlock;
  constexpr int kLargeStepPenalty = 32 * kBlock * kBlock;
  constexpr int kLeftRightTolerance = 1;  // px
  constexpr int kPreFilterCap = 63;
  constexpr int kUniquenessPercent = 10;
  constexpr int kSpeckleArea = 100;  // px
  constexpr int kSpeckleRange = 2;   // px
  const PaddedPair pair(ToGrey(input.left), ToGrey(input.right), input.max_disparity_px, kBlock);
  return MatchPadded(
      *cv::StereoSGBM::create(kFirstDisparity, pair.disparities(), kBlock, kSmallStepPenalty,
                              kLargeStepPenalty, kLeftRightTolerance, kPreFilterCap,
                              kUniquenessPercent, kSpeckleArea, kSpeckleRange, mode),
      pair);
}

cv::Mat1f Compute3Way(const RivalInput& input) {
  return Sgbm(input, cv::StereoSGBM::MODE_SGBM_3WAY);
}

cv::Mat1f Compute5Way(const RivalInput& input) { return Sgbm(input, cv::StereoSGBM::MODE_SGBM); }

}  // namespace

Rival Sgbm3Way() {
  return {.name = "sgbm-3way",
          .summary = "OpenCV's semi-global matching along 3 directions",
          .uses_seeds = false,
          .compute = Compute3Way};
}

Rival Sgbm5Way() {
  return {.name = "sgbm-5way",
          .summary = "OpenCV's semi-global matching along 5 directions",
          .uses_seeds = false,
          .compute = Compute5Way};
}

}  // namespace sprout::evaluate
