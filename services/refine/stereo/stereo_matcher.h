#ifndef SPROUT_SERVICES_REFINE_STEREO_STEREO_MATCHER_H_
#define SPROUT_SERVICES_REFINE_STEREO_STEREO_MATCHER_H_

#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "common/core/seed.h"
#include "services/refine/stereo/semi_global.h"

namespace sprout::refine {

/// The limits of StereoMatcher.
struct StereoMatcherSettings {
  int max_disparity_px = 0;  ///< largest disparity of the images, px; > 0
  bool diagonal = true;      ///< whether paths run so, too
  int most_pixels = 0;       ///< images with more are halved until they have no more; > 0
};

/// How many px of the images are one of the finest image that is matched, along either side.
int MatchingScale(cv::Size size, int most_pixels);

/// Disparities of a rectified pair without a prior: semi-global matching from coarse to fine. The
/// coarsest image (at most 32,000 pixels, fewer when it is very wide) is searched over all
/// disparities; every finer one only around the results of the coarser one.
class StereoMatcher {
 public:
  /// @param left, right  rectified pair, grey, of one size.
  /// @param wanted       8UC1 of that size: nonzero where disparities are wanted.
  /// @param known        reliable correspondences; disparities far from them cost more.
  /// @returns disparities in px of the finest image that was matched (one of its px is scale() px
  /// of the given one). NaN where there is none, or it is not unique, not confirmed from the right
  /// image, or in a patch of fewer than 50 pixels. Valid until the next call.
  /// O(wanted pixels of the finest image). On OpenCV's threads, with the same result for any
  /// number.
  const cv::Mat1f& Match(const cv::Mat1b& left, const cv::Mat1b& right, const cv::Mat1b& wanted,
                         std::span<const Seed> known, const StereoMatcherSettings& settings);

  /// How many pixels of the images a pixel of the matched images is wide, in the last call.
  int scale() const { return scale_; }

 private:
  struct Level {
    cv::Mat1b left, right, wanted;
    int scale = 1;
  };

  void BuildLevels(const cv::Mat1b& left, const cv::Mat1b& right, const cv::Mat1b& wanted,
                   const StereoMatcherSettings& settings);

  std::vector<Level> levels_;  // from the finest to the coarsest
  StereoSearch search_;
  SemiGlobalMatcher matcher_;
  cv::Mat1f disparity_px_;
  int scale_ = 1;
};

}  // namespace sprout::refine

#endif  // SPROUT_SERVICES_REFINE_STEREO_STEREO_MATCHER_H_
