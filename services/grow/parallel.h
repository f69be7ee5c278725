#ifndef SPROUT_SERVICES_GROW_PARALLEL_H_
#define SPROUT_SERVICES_GROW_PARALLEL_H_

#include <cstddef>
#include <opencv2/core.hpp>

#include "common/core/disparity_image.h"

namespace sprout {

/// Runs work(0) to work(count − 1) on OpenCV's threads (cv::setNumThreads), in any order.
template <typename Work>
void ForEachParallel(size_t count, const Work& work) {
  class Body : public cv::ParallelLoopBody {
   public:
    explicit Body(const Work& todo) : todo_(todo) {}
    void operator()(const cv::Range& part) const override {
      for (int i = part.start; i < part.end; ++i) todo_(static_cast<size_t>(i));
    }

   private:
    const Work& todo_;
  };
  const auto end = static_cast<int>(count);
  cv::parallel_for_({0, end}, Body(work), end);
}

/// Makes `map` one of that size to write a new result to: itself when nobody else holds its pixels
/// any more, and a new one otherwise. What it contains is undefined.
inline void Renew(DisparityImage& map, cv::Size size) {
  const bool held = !map.empty() && (map.counts().u == nullptr || map.counts().u->refcount > 1);
  if (held || map.size() != size) map = DisparityImage(cv::Mat1s(size));
}

}  // namespace sprout

#endif  // SPROUT_SERVICES_GROW_PARALLEL_H_
