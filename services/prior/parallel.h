#ifndef SPROUT_SERVICES_PRIOR_PARALLEL_H_
#define SPROUT_SERVICES_PRIOR_PARALLEL_H_

#include <opencv2/core/utility.hpp>

namespace sprout {

/// Runs both on OpenCV's threads, at the same time if there are two. OpenCV gives what runs in one
/// of its threads no others.
template <typename One, typename Other>
void RunBoth(const One& one, const Other& other) {
  cv::parallel_for_({0, 2}, [&](const cv::Range& part) {
    if (part.start == 0) one();
    if (part.end == 2) other();
  });
}

/// Calls paint(rows) for bands of rows that make up the image, on OpenCV's threads. A row is
/// painted by one call, so painting triangles in their order in each gives the same image with any
/// number of threads.
template <typename Paint>
void PaintInBands(int height, const Paint& paint) {
  constexpr int kBandsPerThread = 4;  // bands differ in work
  cv::parallel_for_({0, height}, paint, kBandsPerThread * cv::getNumThreads());
}

}  // namespace sprout

#endif  // SPROUT_SERVICES_PRIOR_PARALLEL_H_
