#pragma once

#include "common/core/prior_map.h"

namespace sprout {

/// A prior that is equally sure wherever it has a disparity. O(pixels).
inline PriorMap EvenPrior(const DisparityImage& disparity, double sigma_px) {
  if (disparity.empty()) return {};
  PriorMap prior{disparity, cv::Mat1b(disparity.size(), SigmaToCounts(sigma_px))};
  prior.sigma.setTo(kMaxSigmaCounts, disparity.counts() == DisparityImage::kInvalid);
  return prior;
}

}  // namespace sprout
