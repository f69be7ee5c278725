#include "common/core/median.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "common/core/parallel.h"

namespace sprout {

// Bands of rows with the window's margin, so that each can be filtered for itself.
void MedianFilter::Apply(const cv::Mat1s& from, cv::Mat1s& to) {
  constexpr int kWindow = 5;
  constexpr int kRows = 64;
  bands_.resize(static_cast<size_t>((from.rows + kRows - 1) / kRows));
  ForEachParallel(bands_.size(), [&](size_t i) {
    const int start = static_cast<int>(i) * kRows;
    const int end = std::min(start + kRows, from.rows);
    const int first = std::max(start - kWindow / 2, 0);
    const int last = std::min(end + kWindow / 2, from.rows);
    cv::medianBlur(from.rowRange(first, last), bands_[i], kWindow);
    bands_[i].rowRange(start - first, end - first).copyTo(to.rowRange(start, end));
  });
}

}  // namespace sprout
