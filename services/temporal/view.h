#pragma once

#include <cstddef>
#include <opencv2/core.hpp>

namespace sprout::temporal {

/// A map or an image as the kernels read it; float or grey.
template <typename T>
struct View {
  const T* pixels;
  ptrdiff_t stride;  // elements from row to row
  int width, height;

  const T* Row(int v) const { return pixels + v * stride; }
};

template <typename T>
View<T> ViewOf(const cv::Mat_<T>& map) {
  return {map[0], static_cast<ptrdiff_t>(map.step1()), map.cols, map.rows};
}

}  // namespace sprout::temporal
