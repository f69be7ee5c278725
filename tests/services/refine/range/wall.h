#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <opencv2/imgproc.hpp>

#include "services/refine/refiner.h"
#include "tests/common/core/centred.h"

namespace sprout::refine {

inline constexpr int kTofStep = 5;      // image px a ToF pixel
inline constexpr int kCoarseStep = 10;  // more than 1.5 cells of stereo
inline const cv::Size kWallSize(500, 350);

// A wall that turns away: d = 20 + 0.06 u px, so between 1.1 and 2.7 m.
inline double TruthPx(double u) { return 20 + 0.06 * u; }

// With texture in both images, and a ToF camera in the left camera's place that sees every fifth
// pixel, or fewer.
struct Wall {
  int step;
  Rig rig;
  cv::Mat1b left{kWallSize};
  cv::Mat1b right{kWallSize};
  TofImage tof;

  explicit Wall(double contrast = 1, int step_px = kTofStep)
      : step(step_px), tof{.depth_m = cv::Mat1f(kWallSize / step), .amplitude = {}} {
    rig.pair = CentredPair(kWallSize.width, kWallSize.height, 540);
    rig.tof.width = tof.depth_m.cols;
    rig.tof.height = tof.depth_m.rows;
    rig.tof.fx = rig.tof.fy = rig.pair.focal_px / step;
    rig.tof.cx = rig.pair.cx / step;
    rig.tof.cy = rig.pair.cy / step;
    cv::RNG(7).fill(left, cv::RNG::UNIFORM, 0, 256);
    cv::GaussianBlur(left, left, {}, 1.2);
    left = 128 + contrast * (left - 128);
    ShowOnTheRight();
    Measure([](const cv::Point2d&, double depth_m) { return depth_m; });
  }

  void ShowOnTheRight() {
    // Right column x shows the left column u with u − d(u) = x.
    cv::Mat1f columns(kWallSize);
    cv::Mat1f rows(kWallSize);
    for (int v = 0; v < kWallSize.height; ++v) {
      for (int x = 0; x < kWallSize.width; ++x) {
        columns(v, x) = static_cast<float>((x + 20) / (1 - 0.06));
        rows(v, x) = static_cast<float>(v);
      }
    }
    cv::remap(left, right, columns, rows, cv::INTER_CUBIC, cv::BORDER_REFLECT);
  }

  // Grey, but for a piece.
  void KeepTextureIn(const cv::Rect& piece) {
    const cv::Mat1b texture = left(piece).clone();
    left = 128;
    texture.copyTo(left(piece));
    ShowOnTheRight();
  }

  // @param measured  what the sensor says of a true depth, m, at a position in the left image.
  void Measure(const std::function<double(const cv::Point2d&, double)>& measured) {
    for (int j = 0; j < tof.depth_m.rows; ++j) {
      for (int i = 0; i < tof.depth_m.cols; ++i) {
        const double true_m = rig.pair.DepthFromDisparity(TruthPx(step * i));
        tof.depth_m(j, i) = static_cast<float>(measured(cv::Point2d(step * i, step * j), true_m));
      }
    }
  }

  SeedSet Refine(RefineConfig::RangeBias bias, double error_m = 0.01) const {
    RefineConfig config;
    config.set_range_bias(bias);
    config.set_range_error_m(error_m);
    config.set_stereo_seeds(false);
    return *Refiner(config).Compute(left, right, tof, TofProjector(rig));
  }
};

// Share of the seeds within a disparity of the truth.
inline double ShareWithin(const SeedSet& set, double px) {
  const auto right = std::count_if(set.seeds.begin(), set.seeds.end(), [&](const Seed& seed) {
    return std::abs(seed.disparity() - TruthPx(seed.u)) <= px;
  });
  return static_cast<double>(right) / static_cast<double>(std::max<size_t>(1, set.seeds.size()));
}

}  // namespace sprout::refine
