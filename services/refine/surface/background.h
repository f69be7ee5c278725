#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "common/core/seed.h"
#include "services/refine/surface/cell_lists.h"

namespace sprout::refine {

/// The background rule alone (paper, II-B): which seeds are background beside a nearer one. Keeps
/// its memory from frame to frame, so one object serves one caller at a time.
class BackgroundRule {
 public:
  /// Every seed that lies, in the left image or in the right one, in the 5×5 window around a seed
  /// (its own or another's) where its disparity is smaller than the window's largest by more than
  /// the tolerance.
  /// @param seeds  inside both images.
  /// @param size   of the images, px.
  /// @returns one flag a seed, 0 or 1; valid until the next call. Does not depend on the order of
  ///          the seeds.
  /// O(n + pixels / 25), for seeds that lie in the same pixels O(n log n), the two images on two of
  /// OpenCV's threads; O(n) when no two seeds differ by more than the tolerance.
  const std::vector<uint8_t>& Find(std::span<const Seed> seeds, cv::Size size, double tolerance_px);

 private:
  // One of the images.
  struct View {
    std::vector<cv::Point2f> pixels;  // of the seeds
    CellLists cells;
    std::vector<float> nearest;  // largest disparity in the windows around the seeds in cells
    std::vector<uint8_t> background;
  };

  static void Mark(std::span<const Seed> seeds, cv::Size size, double tolerance_px, View& view);

  View left_;
  View right_;
  std::vector<uint8_t> background_;
};

}  // namespace sprout::refine
