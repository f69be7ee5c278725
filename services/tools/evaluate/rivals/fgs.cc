#include <opencv2/ximgproc/edge_filter.hpp>

#include "services/tools/evaluate/rivals/rival.h"

namespace sprout::evaluate {
namespace {

// Min et al., "Fast Global Image Smoothing Based on Weighted Least Squares", TIP 2014, IV-B:
// smoothed disparities over smoothed weights, an average of the seeds that no edge of the image
// separates from the pixel. A pixel that no seed reaches is NaN: 0 / 0.
cv::Mat1f ComputeFgs(const RivalInput& input) {
  cv::Mat1f disparity_px(input.left.size(), 0.F);
  cv::Mat1f weight(input.left.size(), 0.F);
  for (const Seed& seed : input.seeds) {
    const cv::Point pixel(cvRound(seed.u), cvRound(seed.v));
    if (!cv::Rect({}, input.left.size()).contains(pixel)) continue;
    disparity_px(pixel) = seed.disparity();
    weight(pixel) = 1;
  }
  const auto smoother =
      cv::ximgproc::createFastGlobalSmootherFilter(input.left, input.fgs.lambda, input.fgs.sigma);
  cv::Mat1f spread_px;
  cv::Mat1f spread_weight;
  smoother->filter(disparity_px, spread_px);
  smoother->filter(weight, spread_weight);
  cv::divide(spread_px, spread_weight, spread_px);
  return spread_px;
}

}  // namespace

Rival Fgs() {
  return {.name = "fgs",
          .summary =
              "OpenCV's FastGlobalSmoother spreads the ToF seeds over the left image, with "
              "--fgs-lambda and --fgs-sigma; never looks at the right one",
          .uses_seeds = true,
          .compute = ComputeFgs};
}

}  // namespace sprout::evaluate
