#include <opencv2/calib3d.hpp>

#include "common/core/image.h"
#include "services/tools/evaluate/rivals/padded_pair.h"
#include "services/tools/evaluate/rivals/rival.h"

namespace sprout::evaluate {
namespace {

// OpenCV's defaults, which drop what is not unique or has no texture.
cv::Mat1f ComputeBm(const RivalInput& input) {
  constexpr int kBlock = 21;
  const PaddedPair pair(ToGrey(input.left), ToGrey(input.right), input.max_disparity_px, kBlock);
  return MatchPadded(*cv::StereoBM::create(pair.disparities(), kBlock), pair);
}

}  // namespace

Rival Bm() {
  return {.name = "bm",
          .summary = "OpenCV's block matching, blocks of 21 px",
          .uses_seeds = false,
          .compute = ComputeBm};
}

}  // namespace sprout::evaluate
