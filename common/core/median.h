#pragma once

#include <opencv2/core.hpp>

#include "common/core/disparity_image.h"

namespace sprout {

/// The same as cv::medianBlur() of 5×5 windows, for each instruction set and on OpenCV's threads.
/// @param from  its border pixels are repeated beyond the border.
/// @param to    of the size of `from`, overwritten; may not share its pixels.
/// O(pixels), 0.5 ns each; the same result for any number of threads.
void FilterByMedian(const cv::Mat1s& from, cv::Mat1s& to);

/// Gaps get the median of the disparities in their 5×5 windows, which end at the map's border (the
/// lower one of two in the middle); gaps without any stay gaps. As FilterByMedian() otherwise.
void FillByMedian(const DisparityImage& from, DisparityImage& to);

}  // namespace sprout
