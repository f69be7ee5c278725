#include "services/prior/seed_spreading.h"

#include <opencv2/imgproc.hpp>
#include <opencv2/ximgproc/edge_filter.hpp>

namespace sprout {

cv::Mat1f SpreadSeeds(std::span<const Seed> seeds, const cv::Mat& left, double lambda, double sigma,
                      int passes) {
  return SeedSpreader().Spread(seeds, left, lambda, sigma, passes);
}

const cv::Mat1f& SeedSpreader::Spread(std::span<const Seed> seeds, const cv::Mat& left,
                                      double lambda, double sigma, int passes) {
  for (cv::Mat1f* image : {&disparity_px_, &weight_}) {
    image->create(left.size());
    *image = 0.F;  // unlike setTo() without memory
  }
  for (const Seed& seed : seeds) {
    const cv::Point pixel(cvRound(seed.u), cvRound(seed.v));
    if (!cv::Rect({}, left.size()).contains(pixel)) continue;
    disparity_px_(pixel) = seed.disparity();
    weight_(pixel) = 1;
  }
  constexpr double kLambdaAttenuation = 0.25;  // from pass to pass, OpenCV's default
  const auto smoother =
      cv::ximgproc::createFastGlobalSmootherFilter(left, lambda, sigma, kLambdaAttenuation, passes);
  smoother->filter(disparity_px_, spread_px_);
  smoother->filter(weight_, spread_weight_);
  cv::divide(spread_px_, spread_weight_, average_);  // NaN where no seed reaches: 0 / 0
  return average_;
}

const cv::Mat1f& SeedSpreader::SpreadAtHalfSize(std::span<const Seed> seeds,
                                                const cv::Mat& half_left, double lambda,
                                                double sigma) {
  half_seeds_.assign(seeds.begin(), seeds.end());
  for (Seed& seed : half_seeds_) {
    const float disparity = seed.disparity();
    seed.u = (seed.u - 0.5F) / 2;
    seed.v = (seed.v - 0.5F) / 2;
    seed.u_right = seed.u - disparity;
  }
  return Spread(half_seeds_, half_left, lambda, sigma, /*passes=*/1);
}

void HalveSize(const cv::Mat& image, cv::Mat& even, cv::Mat& half) {
  const bool is_odd = image.rows % 2 != 0 || image.cols % 2 != 0;
  if (is_odd) {
    cv::copyMakeBorder(image, even, 0, image.rows % 2, 0, image.cols % 2, cv::BORDER_REPLICATE);
  }
  const cv::Mat& from = is_odd ? even : image;
  cv::resize(from, half, from.size() / 2, 0, 0, cv::INTER_AREA);
}

}  // namespace sprout
