#ifndef SPROUT_SERVICES_PRIOR_SEED_SPREADING_H_
#define SPROUT_SERVICES_PRIOR_SEED_SPREADING_H_

#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "common/core/seed.h"

namespace sprout {

/// Spreads the seeds' disparities over the left image with OpenCV's FastGlobalSmoother (Min et al.,
/// "Fast Global Image Smoothing Based on Weighted Least Squares", TIP 2014, IV-B): smoothed
/// disparities over smoothed weights, an average of the seeds that no edge of the image separates
/// from the pixel. Looks at one image only.
///
/// @param seeds   on their nearest pixels; of two on one pixel the later counts, one outside not.
/// @param left    CV_8UC1 or CV_8UC3.
/// @param lambda  strength of the smoothing, > 0.
/// @param sigma   difference of colours over which it hardly goes, grey levels, > 0.
/// @param passes  over rows and columns; OpenCV's own default is 3. More spread further around
///                corners.
/// @returns disparities, px; NaN where no seed reaches, all NaN without seeds.
/// O(pixels); no I/O; uses OpenCV's threads, with the same result for any number.
cv::Mat1f SpreadSeeds(std::span<const Seed> seeds, const cv::Mat& left, double lambda, double sigma,
                      int passes = 3);

/// SpreadSeeds() for frame after frame: keeps its memory, and only OpenCV's filter allocates, anew
/// for each image. One object serves one caller at a time.
class SeedSpreader {
 public:
  /// @returns as SpreadSeeds(); valid until the next call.
  const cv::Mat1f& Spread(std::span<const Seed> seeds, const cv::Mat& left, double lambda,
                          double sigma, int passes = 3);

  /// Spread() for a sixth of its time: one pass over an image of half the size. What it loses is of
  /// no account where it only is a hint.
  /// @param half_left  HalveSize() of the left image.
  /// @returns as Spread(), disparities of the full image, for pixel (u, v) of it at (u / 2, v / 2),
  ///          rounded down.
  const cv::Mat1f& SpreadAtHalfSize(std::span<const Seed> seeds, const cv::Mat& half_left,
                                    double lambda, double sigma);

 private:
  std::vector<Seed> half_seeds_;
  cv::Mat1f disparity_px_;
  cv::Mat1f weight_;
  cv::Mat1f spread_px_;
  cv::Mat1f spread_weight_;
  cv::Mat1f average_;
};

/// Means of 2×2 pixels; the last row and column of an odd image count twice. O(pixels).
/// @param image  CV_8U, any channels.
/// @param even   memory, for an odd image.
/// @param half   is overwritten; its memory is used if it fits.
void HalveSize(const cv::Mat& image, cv::Mat& even, cv::Mat& half);

}  // namespace sprout

#endif  // SPROUT_SERVICES_PRIOR_SEED_SPREADING_H_
