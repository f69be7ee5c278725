#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "services/refine/stereo/stereo_search.h"

namespace sprout::refine {

/// Four of the eight directions of semi-global matching: for each label of a pixel the costs of the
/// cheapest paths that end there (eq. (R14) of the README), added up. The paths come from the
/// previous pixel and from the three nearest pixels of the previous row.
/// @param step  1: rows from the first to the last one, and the pixels in them; −1: the other way.
/// @param costs  of the data term, MatchCosts.
/// @param sums   gets search.labels sums for each pixel of the rows, undefined for pixels that are
///               left out; longer than `costs` if it was.
/// O(pixels of the rows · labels), about 20 ns for 16 labels; thread-safe.
void AddUpPaths(const cv::Mat1b& left, const StereoSearch& search, const SearchRows& rows,
                const std::vector<uint8_t>& costs, int step, std::vector<uint16_t>& sums);

}  // namespace sprout::refine
