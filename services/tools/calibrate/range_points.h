#pragma once

#include <vector>

#include "services/tools/calibrate/rig_model.h"

namespace sprout::calibrate {

/// What the ToF camera measures on one square of the board: the mean of its pixels there.
struct RangePoint {
  size_t view = 0;
  cv::Point2d pixel;   ///< of the ToF image, px
  double depth_m = 0;  ///< as measured, along the optical axis
};

/// The squares of the board in all views that have enough returns. The model gives their positions;
/// depths are averaged as 1/z, which is linear in the pixel on a plane. O(ToF pixels).
std::vector<RangePoint> CollectRangePoints(const Board& board, const std::vector<BoardView>& views,
                                           const RigModel& model);

}  // namespace sprout::calibrate
