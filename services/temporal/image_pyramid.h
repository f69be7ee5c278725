#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace sprout::temporal {

/// Most pixels of the finest level: finer images make the motion no surer, only slower to find.
inline constexpr int kMaxTrackedPixels = 600000;

/// Rows of an image that a thread takes at once.
inline constexpr int kRowsPerPart = 16;

/// An image and halves of it, each the mean of 2×2 pixels, rounded. An odd last row or column is
/// left out.
struct ImagePyramid {
  std::vector<cv::Mat1b> levels;  ///< the finest one first; none for an empty image
  int scale = 1;                  ///< pixels of the image on the side of one of the finest level
};

/// Halves the image until it has at most kMaxTrackedPixels, then on until a side would be below 32
/// px. The finest level may share the image's pixels. O(pixels).
ImagePyramid BuildPyramid(const cv::Mat1b& image);

}  // namespace sprout::temporal
