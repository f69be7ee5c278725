#pragma once

#include <opencv2/core.hpp>

namespace sprout::scenes {

/// Whether two 8-bit images, grey or BGR, show the same picture, if not the same bytes: one may
/// have been compressed with loss. False when their sizes differ. O(pixels).
bool IsSamePicture(const cv::Mat& a, const cv::Mat& b);

}  // namespace sprout::scenes
