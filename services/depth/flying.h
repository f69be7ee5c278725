#pragma once

#include <opencv2/core.hpp>

#include "common/core/disparity_image.h"

namespace sprout::depth {

/// The pixels of a map that hang between two surfaces, as 255: along the row or the column there is
/// a nearer pixel on one side and a farther one on the other, and few pixels around have their
/// disparity. Kept are both edges of a step, thin objects in front of a surface, and slanted
/// surfaces up to 0.77 disparities a pixel. O(pixels), and more for the pixels that are between
/// two.
cv::Mat1b FindFlying(const DisparityImage& map);

}  // namespace sprout::depth
