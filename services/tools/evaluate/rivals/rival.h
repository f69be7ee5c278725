#pragma once

#include <opencv2/core.hpp>
#include <span>
#include <string>
#include <vector>

#include "common/core/seed.h"

namespace sprout::evaluate {

/// How fgs smooths.
struct FgsSettings {
  double lambda = 10;  ///< how far seeds spread; larger: smoother, over weaker edges
  double sigma = 3;    ///< difference of colours across which they hardly spread, grey levels
};

/// Inputs of a rival.
struct RivalInput {
  cv::Mat left;   ///< 8UC1 or 8UC3 (BGR), rectified
  cv::Mat right;  ///< of the same size and type
  /// Refined ToF seeds, also those that only the left camera sees, for rivals that use the ToF
  /// camera.
  std::span<const Seed> seeds;
  int max_disparity_px = 0;  ///< largest true disparity of the scene, rounded up
  FgsSettings fgs = {};
};

/// Another method that a user might run instead of Sprout. To add one: its function and its row
/// in AllRivals(), rivals.cc.
struct Rival {
  std::string name;     ///< of the method, for --methods
  std::string summary;  ///< one line for --help
  bool uses_seeds;      ///< if not, its time does not include refinement
  /// @returns disparities of the left image's pixels, px, NaN = none.
  cv::Mat1f (*compute)(const RivalInput& input);
};

std::vector<Rival> AllRivals();

}  // namespace sprout::evaluate
