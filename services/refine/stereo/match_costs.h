#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "services/refine/stereo/stereo_search.h"

namespace sprout::refine {

/// The data term C(p, d) of semi-global matching, eq. (R15): the Hamming distance of the census
/// transforms (5×5, 24 bits) of a left pixel and its match, and how much their slopes of grey
/// differ. Keeps its memory: a byte a label, and 10 a pixel of the image.
class MatchCosts {
 public:
  /// @param left, right  rectified pair, grey, of one size, at least 5×5.
  /// @param rows         of the search.
  /// @returns search.labels costs for each pixel of the rows, undefined for pixels that are left
  ///          out; valid until the next call.
  /// O(pixels of the rows · labels). On OpenCV's threads, with the same result for any number.
  const std::vector<uint8_t>& Compute(const cv::Mat1b& left, const cv::Mat1b& right,
                                      const StereoSearch& search, const SearchRows& rows);

 private:
  // Bits of a pixel, then its slope.
  using Planes = std::array<cv::Mat1b, StereoRules::kBits / 8 + 1>;

  cv::Mat1b left_bordered_, right_bordered_;  // as the images' borders go on
  Planes left_, right_;
  std::vector<uint8_t> costs_;
};

}  // namespace sprout::refine
