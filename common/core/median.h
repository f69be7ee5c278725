#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace sprout {

/// cv::medianBlur() of 5×5 windows, on OpenCV's threads. Keeps its memory from frame to frame; one
/// object serves one caller at a time.
class MedianFilter {
 public:
  /// @param from  its border pixels are repeated beyond the border.
  /// @param to    of the size of `from`, overwritten; may not share its pixels.
  /// O(pixels); the same result for any number of threads.
  void Apply(const cv::Mat1s& from, cv::Mat1s& to);

 private:
  std::vector<cv::Mat1s> bands_;
};

}  // namespace sprout
