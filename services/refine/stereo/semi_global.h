#ifndef SPROUT_SERVICES_REFINE_STEREO_SEMI_GLOBAL_H_
#define SPROUT_SERVICES_REFINE_STEREO_SEMI_GLOBAL_H_

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "services/refine/stereo/match_costs.h"
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

}  // namespace sprout::refine

#endif  // SPROUT_SERVICES_REFINE_STEREO_SEMI_GLOBAL_H_
