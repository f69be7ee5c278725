#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace sprout {

/// How wide a depth edge is, line by line.
struct EdgeWidths {
  std::vector<float> px;     ///< of each line that the edge crosses
  int64_t without_edge = 0;  ///< lines without a step, or without disparities on both sides
};

/// A step of disparity below this, px, is no depth edge: growth lets neighbours of one surface
/// differ by that much.
inline constexpr double kMinEdgeStepPx = 1;

/// Measures the depth edge that crosses a map. The lines are its rows, or its columns when the edge
/// lies along the rows: the direction in which the outer quarters of the map differ more. Of each
/// line the far and the near side have the medians d_f and d_n of its outer quarters. Between the
/// pixels that have a disparity it is interpolated linearly. Its width is the distance between the
/// places where
///
///     (d − d_f) / (d_n − d_f) = 0.1 and 0.9
///
/// that are next to the middle of the edge (0.5), so noise on either side does not move them. A
/// step between two neighbours has 0.8 px where both sides are square to the camera; a hole of n px
/// in it 0.8 · (n + 1). Below 8 px the straight lines between pixels make it up to half a pixel too
/// wide.
/// @param disparity_px  NaN or infinite = none. O(pixels).
EdgeWidths MeasureEdge(const cv::Mat1f& disparity_px);

}  // namespace sprout
