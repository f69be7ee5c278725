#ifndef SPROUT_COMMON_RIG_BILINEAR_REMAP_H_
#define SPROUT_COMMON_RIG_BILINEAR_REMAP_H_

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace sprout {

/// For each pixel of a rectified image the place in the source image that it comes from, to 1/32
/// px. Places beyond the image are those on its border. The same bytes as cv::remap with
/// INTER_LINEAR and BORDER_REPLICATE, in a fraction of its time (services/capture/NOTES.md).
/// Thread-compatible; copies share the maps, but not groups that no window holds.
class BilinearRemap {
 public:
  /// So many pixels of a row come from one window of the source, three rows of 16 pixels, as a
  /// rule.
  static constexpr int kGroup = 8;

  BilinearRemap() = default;

  /// @param places  column and row of the source, px; the result has its size.
  /// @param source  size of the source images, px.
  /// 3.5 bytes a pixel are kept, and 4 more of each in a group that no window holds.
  BilinearRemap(const cv::Mat2f& places, cv::Size source);

  cv::Size source_size() const { return source_; }

  /// In fixed point: the same bytes on every CPU. O(pixels), rows in parallel.
  /// @param image  8UC1 or 8UC3, of source_size().
  cv::Mat Apply(const cv::Mat& image) const;

 private:
  void AddGroup(int v, int group, const std::array<cv::Point, kGroup>& pixels);

  cv::Size source_;
  cv::Size size_;
  // Of each group the first pixel of its window, in pixels from the first one of the image; or −1 −
  // its place in `apart_`.
  cv::Mat1i windows_;
  // Of each pixel the upper left one of four in the window: column, and 16 · row.
  cv::Mat1b places_;
  cv::Mat1w weights_;  // of the right ones, and 256 · of the lower ones, in 1/32
  // Groups that no window holds: the upper left pixels, from the first one of the image.
  std::vector<std::array<int32_t, kGroup>> apart_;
};

}  // namespace sprout

#endif  // SPROUT_COMMON_RIG_BILINEAR_REMAP_H_
