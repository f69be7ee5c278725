#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>

#include "common/core/disparity_image.h"

namespace sprout {

// Work for OpenCV's threads (cv::setNumThreads). Nested calls run serially, as nested parallel_for_
// does. Nothing here allocates, as the std::function of cv::parallel_for_ would; OpenCV itself
// does so once a call when it has more than one thread.

/// Runs work(part) for ranges that together are [0, count), in any order. A thread that has
/// finished one takes the next, so that threads end at nearly the same time; OpenCV itself assigns
/// several ranges at once.
/// @param parts  largest number of ranges.
template <typename Work>
void ForRangesParallel(int count, int parts, const Work& work) {
  constexpr int kMaxParts = 64;  // more would cost more time than they balance
  const int64_t ranges = std::min({count, parts, kMaxParts});
  const int threads = static_cast<int>(std::min<int64_t>(cv::getNumThreads(), ranges));
  if (count <= 0) return;
  if (threads <= 1) return work(cv::Range(0, count));
  std::atomic<int64_t> next = 0;
  const auto take_ranges = [&] {
    for (int64_t i = next++; i < ranges; i = next++) {
      work(cv::Range(static_cast<int>(count * i / ranges),
                     static_cast<int>(count * (i + 1) / ranges)));
    }
  };
  class Body : public cv::ParallelLoopBody {
   public:
    explicit Body(const decltype(take_ranges)& todo) : todo_(todo) {}
    void operator()(const cv::Range&) const override { todo_(); }

   private:
    const decltype(take_ranges)& todo_;
  };
  cv::parallel_for_({0, threads}, Body(take_ranges), threads);
}

/// Runs work(0) to work(count − 1), in any order.
template <typename Work>
void ForEachParallel(size_t count, const Work& work) {
  const auto end = static_cast<int>(count);
  ForRangesParallel(end, end, [&](const cv::Range& part) {
    for (int i = part.start; i < part.end; ++i) work(static_cast<size_t>(i));
  });
}

/// Runs both, at the same time if there are two threads.
template <typename One, typename Other>
void RunBoth(const One& one, const Other& other) {
  ForRangesParallel(2, 2, [&](const cv::Range& part) {
    if (part.start == 0) one();
    if (part.end == 2) other();
  });
}

/// Prepares `map` for a new result of that size: reuses its memory if nobody else holds its pixels,
/// otherwise allocates. Its content is undefined.
template <typename T>
void Renew(cv::Mat_<T>& map, cv::Size size) {
  const bool held = !map.empty() && (map.u == nullptr || map.u->refcount > 1);
  if (held || map.size() != size) map = cv::Mat_<T>(size);
}
inline void Renew(DisparityImage& map, cv::Size size) { Renew(map.counts(), size); }

}  // namespace sprout
