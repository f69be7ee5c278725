#ifndef SPROUT_SERVICES_REFINE_SEMI_GLOBAL_H_
#define SPROUT_SERVICES_REFINE_SEMI_GLOBAL_H_

#include <array>
#include <cstdint>
#include <limits>
#include <opencv2/core.hpp>
#include <vector>

namespace sprout {

/// Where semi-global matching looks, and what is known before.
struct StereoSearch {
  static constexpr int16_t kNowhere = -1;

  /// Least disparity that is looked at, px, ≥ 0; kNowhere = the pixel is left out.
  cv::Mat1s first;
  /// Disparities that are looked at from there on; a multiple of 16.
  int labels = 16;
  /// Disparity that a range sensor gives for the pixel, px; kNowhere = none.
  cv::Mat1s known;
};

/// What it found.
struct StereoMatches {
  /// The best disparity of every pixel that was looked at, px; kNowhere elsewhere.
  cv::Mat1s best;
  /// The same to a fraction of a pixel, where it is unique and confirmed from the right image; NaN
  /// elsewhere.
  cv::Mat1f confirmed_px;
};

/// Semi-global matching (Hirschmüller, PAMI 2008): the disparities that minimise along eight
/// directions the Hamming distance of census transforms (5×5, 24 bits) plus a penalty for every
/// change of disparity. The penalty of larger changes falls with the difference of grey values.
///
/// Every pixel has a range of disparities of its own, so that what a coarser image has shown is not
/// searched again. Costs are whole numbers of 8 bits: the same result on every machine.
class SemiGlobalMatcher {
 public:
  /// @param left, right  rectified pair, grey, of one size, at least 5×5.
  /// @param search       `first` and `known` of that size.
  /// @returns valid until the next call.
  /// O(pixels looked at · labels): 16 labels take about 0.2 µs a pixel. On OpenCV's threads, with
  /// the same result for any number. Keeps its memory, 5 bytes a label of a pixel.
  const StereoMatches& Match(const cv::Mat1b& left, const cv::Mat1b& right,
                             const StereoSearch& search);

 private:
  class Sweep;
  class RowChoice;

  static constexpr size_t kPlanes = 3;  // of 8 bits
  using CensusPlanes = std::array<cv::Mat1b, kPlanes>;

  void Census(const cv::Mat1b& image, bool mirrored, int spare, CensusPlanes& planes);
  void FillCosts(const cv::Mat1b& left, const cv::Mat1b& right, const StereoSearch& search);
  void FillPixel(const StereoSearch& search, int v, int u, uint8_t* costs) const;

  cv::Mat1b bordered_;
  CensusPlanes left_census_, right_census_;
  std::vector<uint8_t> costs_;                 // of a pixel's labels
  std::array<std::vector<uint16_t>, 2> sums_;  // over the directions of either sweep
  StereoMatches matches_;
};

}  // namespace sprout

#endif  // SPROUT_SERVICES_REFINE_SEMI_GLOBAL_H_
