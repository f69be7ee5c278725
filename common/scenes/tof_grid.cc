#include "common/scenes/tof_grid.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <string>

#include "common/config/config_error.h"

namespace sprout::scenes {
namespace {

// Left pixel that column or row `index` of the grid looks through.
int LeftPixel(int index, int step_px) { return index * step_px + step_px / 2; }

}  // namespace

TofCamera TofGridCamera(const RectifiedPair& pair, int step_px) {
  const int largest = std::min(pair.width, pair.height);
  if (step_px < 1 || step_px > largest) {
    throw ConfigError("capture.tof_grid_px = " + std::to_string(step_px) + ": images of " +
                      std::to_string(pair.width) + "x" + std::to_string(pair.height) +
                      " px hold no ToF point; allowed: 1 to " + std::to_string(largest));
  }
  const double step = step_px;
  const double first = LeftPixel(0, step_px);
  TofCamera tof;
  tof.width = pair.width / step_px;
  tof.height = pair.height / step_px;
  // (i·step + first − cx) / focal, the left ray of grid column i, written as (i − tof.cx) / tof.fx.
  tof.fx = tof.fy = pair.focal_px / step;
  tof.cx = (pair.cx - first) / step;
  tof.cy = (pair.cy - first) / step;
  return tof;
}

TofImage SampleTofGrid(const RectifiedPair& pair, int step_px, const cv::Mat1f& left_disparity) {
  assert(left_disparity.size() == pair.size());
  TofImage tof;
  tof.depth_m.create(pair.height / step_px, pair.width / step_px);
  for (int j = 0; j < tof.depth_m.rows; ++j) {
    for (int i = 0; i < tof.depth_m.cols; ++i) {
      const float disparity = left_disparity(LeftPixel(j, step_px), LeftPixel(i, step_px));
      const auto depth_m = static_cast<float>(pair.DepthFromDisparity(disparity));
      const bool valid = std::isfinite(depth_m) && depth_m > 0;
      tof.depth_m(j, i) = valid ? depth_m : std::numeric_limits<float>::quiet_NaN();
    }
  }
  return tof;
}

}  // namespace sprout::scenes
