#pragma once

#include <opencv2/core.hpp>
#include <string>

#include "common/core/rig.h"
#include "common/scenes/dataset.h"

namespace sprout {

/// One frame to measure on.
struct BenchFrame {
  Rig rig;
  scenes::DatasetFrame frame;  ///< images as captured, colour on the left
  cv::Mat1b left;              ///< grey, as the stages look at them
  cv::Mat1b right;
  int max_disparity_px = 0;
};

/// A Middlebury scene in another size: images resized, true disparities with them, and the ToF
/// camera of the paper (every tenth pixel) simulated anew from these.
/// @throws ConfigError when the scene cannot be read.
BenchFrame LoadBenchFrame(const std::string& folder, cv::Size size);

/// Takes the returns on the darkest surfaces away, as a real ToF camera has none there.
/// @param share  of all returns, 0 to 1.
void LoseDarkReturns(double share, BenchFrame& bench);

}  // namespace sprout
