#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "common/core/seed.h"
#include "services/refine/stereo/stereo_search.h"

namespace sprout::refine {

/// What semi-global matching found.
struct StereoMatches {
  /// The best disparity of every pixel that was searched, px; kNowhere elsewhere.
  cv::Mat1s best;
  /// If search.confirm: the disparity with a sub-pixel part, where it is unique and confirmed from
  /// the right image; NaN elsewhere.
  cv::Mat1f confirmed_px;
};

/// Semi-global matching (Hirschmüller, PAMI 2008): the disparities that minimise along eight
/// directions MatchCosts plus a penalty for every change of disparity. The penalty of larger
/// changes falls with the difference of grey values.
///
/// Every pixel has its own range of disparities: disparities that a coarser image has ruled out are
/// not searched again. Costs are whole numbers of 8 bits: the same result on every machine.
class SemiGlobalMatcher {
 public:
  /// @param left, right  rectified pair, grey, of one size, at least 5×5.
  /// @param search       `first` and `known` of that size.
  /// @returns valid until the next call.
  /// O(pixels looked at · labels): 16 labels take about 0.1 µs a pixel. On OpenCV's threads, with
  /// the same result for any number. Keeps its memory, 5 bytes a label of a pixel.
  const StereoMatches& Match(const cv::Mat1b& left, const cv::Mat1b& right,
                             const StereoSearch& search);

 private:
  SearchRows rows_;
  MatchCosts match_costs_;
  std::array<std::vector<uint16_t>, 2> sums_;  // over the directions of either sweep
  StereoMatches matches_;
};

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
