#pragma once

#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/core.hpp>
#include <random>

#include "common/core/rig.h"

namespace sprout::testing {

/// A pair that looks at a target about 1.5 m away: 90 px of disparity.
inline RectifiedPair TargetPair() {
  return {.width = 320,
          .height = 240,
          .focal_px = 900,
          .cx = 165,
          .cy = 115,
          .cx_right = 162,
          .baseline_m = 0.15};
}

/// A plane at a distance, square to it, from the left camera.
struct FlatTarget {
  double distance_m = 1.5;
  double horizontal_deg = 0;  ///< > 0: the right side is farther
  double vertical_deg = 0;    ///< > 0: the lower side is farther

  double DepthAt(const RectifiedPair& pair, double u, double v) const {
    const auto slope = [](double degrees) { return std::tan(degrees * std::numbers::pi / 180); };
    const Eigen::Vector3d normal =
        Eigen::Vector3d(-slope(horizontal_deg), -slope(vertical_deg), 1).normalized();
    const Eigen::Vector3d ray((u - pair.cx) / pair.focal_px, (v - pair.cy) / pair.focal_px, 1);
    return distance_m / normal.dot(ray);
  }

  /// Its exact disparities.
  cv::Mat1f Disparity(const RectifiedPair& pair) const {
    cv::Mat1f map(pair.size());
    for (int v = 0; v < map.rows; ++v) {
      for (int u = 0; u < map.cols; ++u) {
        map(v, u) = static_cast<float>(pair.DisparityFromDepth(DepthAt(pair, u, v)));
      }
    }
    return map;
  }
};

/// The same random numbers in every run.
class TargetNoise {
 public:
  double Normal(double deviation) { return deviation * normal_(engine_); }
  double Uniform() { return uniform_(engine_); }  ///< 0 to 1

  /// Adds normal noise to disparities, px.
  cv::Mat1f On(const cv::Mat1f& map, double deviation_px) {
    cv::Mat1f noisy = map.clone();
    for (float& d : noisy) d += static_cast<float>(Normal(deviation_px));
    return noisy;
  }

 private:
  std::mt19937 engine_{7};
  std::normal_distribution<double> normal_;
  std::uniform_real_distribution<double> uniform_;
};

inline constexpr float kNoDisparity = std::numeric_limits<float>::quiet_NaN();

}  // namespace sprout::testing
