#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "services/refine/stereo/stereo_rules.h"

namespace sprout::refine {

/// Which disparities semi-global matching searches, and which are known from a range sensor.
struct StereoSearch {
  static constexpr int16_t kNowhere = -1;

  /// Smallest disparity that is searched, px, ≥ 0; kNowhere = the pixel is left out.
  cv::Mat1s first;
  /// Number of disparities searched from `first` on, the labels of the pixel: 16, or a larger
  /// multiple of 16 when `first` is the same at all pixels where it is not kNowhere.
  int labels = StereoRules::kLabels;
  /// Disparity that a range sensor gives for the pixel, px; kNowhere = none.
  cv::Mat1s known;
  /// Whether paths run diagonally, too.
  bool diagonal = true;
  /// Whether matches are to be confirmed, or only the best ones are wanted.
  bool confirm = true;
};

/// In every row the pixels from the first to the last one that is searched: memory and time are
/// proportional to these, not to the whole image.
class SearchRows {
 public:
  /// O(pixels of the image), about 0.3 ns each.
  void Set(const StereoSearch& search);

  int count() const { return static_cast<int>(columns_.size()); }

  /// Empty when the row is left out.
  const cv::Range& columns(int v) const { return columns_[static_cast<size_t>(v)]; }

  /// Number of the pixels that are searched, in all rows.
  size_t pixels() const { return begin_.back(); }

  /// Index of such a pixel, row by row: its labels begin at this index times the labels a pixel in
  /// an array of all labels.
  size_t IndexOf(int v, int u) const {
    return begin_[static_cast<size_t>(v)] + static_cast<size_t>(u - columns(v).start);
  }

 private:
  std::vector<cv::Range> columns_;
  std::vector<size_t> begin_;  // index of the rows' first pixels, and the end of the last
};

/// The data term C(p, d) of semi-global matching, eq. (M5): the Hamming distance of the census
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

/// Four of the eight directions of semi-global matching: for each label of a pixel the costs of the
/// cheapest paths that end there (eq. (M4) of the README), added up. The paths come from the
/// previous pixel and from the three nearest pixels of the previous row.
/// @param step  1: rows from the first to the last one, and the pixels in them; −1: the other way.
/// @param costs  of the data term, MatchCosts.
/// @param sums   gets search.labels sums for each pixel of the rows, undefined for pixels that are
///               left out; longer than `costs` if it was.
/// O(pixels of the rows · labels), about 20 ns for 16 labels; thread-safe.
void AddUpPaths(const cv::Mat1b& left, const StereoSearch& search, const SearchRows& rows,
                const std::vector<uint8_t>& costs, int step, std::vector<uint16_t>& sums);

/// The best matches of the pixels of a row, from the path sums of both sweeps. Keeps its memory
/// from row to row.
class BestMatches {
 public:
  /// @param down, up      sums for the row's pixels, AddUpPaths.
  /// @param best          gets the disparity of the smallest sum, px, of every pixel that is
  ///                      searched.
  /// @param confirmed_px  the same with a sub-pixel part, where it is unique and confirmed from the
  /// right image; null: not wanted. Other pixels of both stay as they are.
  /// O(pixels of the row · labels).
  void Choose(const StereoSearch& search, int v, const cv::Range& columns, const uint16_t* down,
              const uint16_t* up, int16_t* best, float* confirmed_px);

 private:
  // The smallest sum of each pixel of the right image, and its disparity.
  std::vector<uint16_t> right_sums_, right_best_;
};

}  // namespace sprout::refine
