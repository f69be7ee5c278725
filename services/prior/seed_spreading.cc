#include "services/prior/seed_spreading.h"

#include <opencv2/ximgproc/edge_filter.hpp>

namespace sprout {

cv::Mat1f SpreadSeeds(std::span<const Seed> seeds, const cv::Mat& left, double lambda,
                      double sigma) {
  cv::Mat1f disparity_px(left.size(), 0.F);
  cv::Mat1f weight(left.size(), 0.F);
  for (const Seed& seed : seeds) {
    const cv::Point pixel(cvRound(seed.u), cvRound(seed.v));
    if (!cv::Rect({}, left.size()).contains(pixel)) continue;
    disparity_px(pixel) = seed.disparity();
    weight(pixel) = 1;
  }
  const auto smoother = cv::ximgproc::createFastGlobalSmootherFilter(left, lambda, sigma);
  cv::Mat1f spread_px;
  cv::Mat1f spread_weight;
  smoother->filter(disparity_px, spread_px);
  smoother->filter(weight, spread_weight);
  cv::divide(spread_px, spread_weight, spread_px);  // NaN where no seed reaches: 0 / 0
  return spread_px;
}

}  // namespace sprout
