#include "services/prior/seed_spreading.h"

#include <opencv2/imgproc.hpp>
#include <opencv2/ximgproc/edge_filter.hpp>
#include <vector>

namespace sprout {

cv::Mat1f SpreadSeeds(std::span<const Seed> seeds, const cv::Mat& left, double lambda, double sigma,
                      int passes) {
  cv::Mat1f disparity_px(left.size(), 0.F);
  cv::Mat1f weight(left.size(), 0.F);
  for (const Seed& seed : seeds) {
    const cv::Point pixel(cvRound(seed.u), cvRound(seed.v));
    if (!cv::Rect({}, left.size()).contains(pixel)) continue;
    disparity_px(pixel) = seed.disparity();
    weight(pixel) = 1;
  }
  constexpr double kLambdaAttenuation = 0.25;  // from pass to pass, OpenCV's default
  const auto smoother =
      cv::ximgproc::createFastGlobalSmootherFilter(left, lambda, sigma, kLambdaAttenuation, passes);
  cv::Mat1f spread_px;
  cv::Mat1f spread_weight;
  smoother->filter(disparity_px, spread_px);
  smoother->filter(weight, spread_weight);
  cv::Mat1f average;
  cv::divide(spread_px, spread_weight, average);  // NaN where no seed reaches: 0 / 0
  return average;
}

cv::Mat HalfSize(const cv::Mat& image) {
  cv::Mat even = image;
  if (image.rows % 2 != 0 || image.cols % 2 != 0) {
    cv::copyMakeBorder(image, even, 0, image.rows % 2, 0, image.cols % 2, cv::BORDER_REPLICATE);
  }
  cv::Mat half;
  cv::resize(even, half, even.size() / 2, 0, 0, cv::INTER_AREA);
  return half;
}

cv::Mat1f SpreadSeedsAtHalfSize(std::span<const Seed> seeds, const cv::Mat& half_left,
                                double lambda, double sigma) {
  std::vector<Seed> half_seeds(seeds.begin(), seeds.end());
  for (Seed& seed : half_seeds) {
    const float disparity = seed.disparity();
    seed.u = (seed.u - 0.5F) / 2;
    seed.v = (seed.v - 0.5F) / 2;
    seed.u_right = seed.u - disparity;
  }
  return SpreadSeeds(half_seeds, half_left, lambda, sigma, /*passes=*/1);
}

}  // namespace sprout
