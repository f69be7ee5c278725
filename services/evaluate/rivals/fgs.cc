#include <cmath>
#include <opencv2/ximgproc/edge_filter.hpp>

#include "services/evaluate/rivals/rival.h"

namespace sprout {
namespace {

constexpr double kLambda = 10;     // strength of the smoothing
constexpr double kSigmaColor = 3;  // difference of colours over which it hardly goes, grey levels

struct Sparse {
  cv::Mat1f disparity_px;  // 0 where there is no seed
  cv::Mat1f weight;        // 1 where there is one, else 0
};

// Seeds on their nearest pixels; of two on one the later counts.
Sparse Rasterize(std::span<const Seed> seeds, cv::Size size) {
  Sparse sparse{cv::Mat1f(size, 0.F), cv::Mat1f(size, 0.F)};
  for (const Seed& seed : seeds) {
    const cv::Point pixel(cvRound(seed.u), cvRound(seed.v));
    if (!cv::Rect({}, size).contains(pixel)) continue;
    sparse.disparity_px(pixel) = seed.disparity();
    sparse.weight(pixel) = 1;
  }
  return sparse;
}

// Smoothed disparities over smoothed weights: an average of the seeds that an edge of the left
// image does not separate from the pixel (Min et al., TIP 2014, IV-B).
cv::Mat1f Compute(const RivalInput& input) {
  const Sparse sparse = Rasterize(input.seeds, input.left.size());
  const auto smoother =
      cv::ximgproc::createFastGlobalSmootherFilter(input.left, kLambda, kSigmaColor);
  cv::Mat1f disparity_px;
  cv::Mat1f weight;
  smoother->filter(sparse.disparity_px, disparity_px);
  smoother->filter(sparse.weight, weight);
  cv::Mat1f average;
  cv::divide(disparity_px, weight, average);  // NaN where no seed reaches: 0 / 0
  return average;
}

}  // namespace

Rival Fgs() {
  return {.name = "fgs",
          .summary =
              "OpenCV's FastGlobalSmoother spreads the ToF seeds over the left image; never "
              "looks at the right one",
          .uses_seeds = true,
          .compute = Compute};
}

}  // namespace sprout
