#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace sprout {

/// Maps each pixel of a rectified image to its position in the source image, to 1/32 px. Positions
/// outside the image are moved to its border. The same bytes as cv::remap with INTER_LINEAR and
/// BORDER_REPLICATE, in a fraction of its time (services/capture/NOTES.md). Thread-compatible;
/// copies share the maps, except for groups of pixels that fit into no window.
class BilinearRemap {
 public:
  /// Pixels of a row that usually come from one window of the source, three rows of 16 pixels.
  static constexpr int kGroup = 8;

  BilinearRemap() = default;

  /// @param places  column and row of the source, px; the result has its size.
  /// @param source  size of the source images, px.
  /// Takes 3.5 bytes a pixel, and 4 more for pixels of groups that fit into no window.
  BilinearRemap(const cv::Mat2f& places, cv::Size source);

  /// In fixed point: the same bytes on every CPU. O(pixels), rows in parallel.
  /// @param image  8UC1 or 8UC3, of the size of the source images.
  cv::Mat Apply(const cv::Mat& image) const;

 private:
  void AddGroup(int v, int group, const std::array<cv::Point, kGroup>& pixels);

  cv::Size source_;
  cv::Size size_;
  // For each group the index in the image of the first pixel of its window; or −1 − its index in
  // `apart_`.
  cv::Mat1i windows_;
  // For each pixel the upper left one of its four in the window: column + 16 · row.
  cv::Mat1b places_;
  cv::Mat1w weights_;  // of the right pixels + 256 · of the lower ones, in 1/32
  // Groups that fit into no window: indices of the upper left pixels in the image.
  std::vector<std::array<int32_t, kGroup>> apart_;
};

}  // namespace sprout
