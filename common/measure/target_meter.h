#pragma once

#include <cstdint>
#include <deque>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/core/result.h"
#include "common/core/rig.h"
#include "common/measure/plane_fit.h"
#include "common/measure/target_quality.h"

namespace sprout {

/// What is measured, and where.
struct TargetSettings {
  std::optional<cv::Rect> region =
      {};                             ///< of the left image, px; nothing: its middle half, each way
  std::optional<cv::Rect> edge = {};  ///< crossed by one depth edge; nothing: no edge is measured
  std::optional<double> distance_m = {};  ///< true distance, square to the target
  size_t count = 40;                      ///< of the newest frames, at least 1
};

/// What is true of the pixels of the region, over the frames.
struct TargetMaps {
  cv::Mat1f residual_mm;  ///< mean of depth minus that of the frame's plane; NaN: never a depth
  cv::Mat1f noise_mm;     ///< standard deviation over the frames; NaN: not always a depth
  std::optional<DisparityPlane> plane;  ///< mean of the frames'
};

/// Measures a flat target that stands still, over the newest `count` frames: RMS and fill of all of
/// them together, noise of every pixel from frame to frame. For one thread.
///
/// Memory: 4 bytes a pixel of the region and frame.
class TargetMeter {
 public:
  /// @param size  of the maps to come. @pre pair is a calibration that CheckRig() takes.
  /// @returns an error naming what is allowed for a region that does not lie in a map of that size,
  ///          is smaller than kMinSide a side, or for a calibration of another size.
  static Result<TargetMeter> For(const TargetSettings& settings, const RectifiedPair& pair,
                                 cv::Size size);

  static constexpr int kMinSide = 8;  ///< px

  /// Takes a frame. @param disparity_px  of the size of For(); NaN or infinite = none.
  /// @param sigma  standard deviations of the disparities as PriorMap has them, or empty.
  /// @pre the sizes are right. O(pixels of the region).
  void Add(const cv::Mat1f& disparity_px, const cv::Mat1b& sigma);

  /// O(frames · pixels of the region).
  TargetQuality Quality() const;
  TargetMaps Maps() const;

  const cv::Rect& region() const { return region_; }
  const std::optional<cv::Rect>& edge() const { return edge_; }
  const RectifiedPair& pair() const { return pair_; }
  size_t frames() const { return frames_.size(); }

 private:
  // What Add() has measured in one frame.
  struct Measured {
    cv::Mat1f depth_m;  // of the region; NaN: none
    std::optional<PlaneFit> fit;
    int64_t valid = 0;
    double sum_squares_m2 = 0;  // of the inliers
    double sum_squares_px2 = 0;
    bool has_sigma = false;
    double sum_sigma_px2 = 0;  // of the inliers
    int64_t within_1 = 0;      // of the valid
    int64_t within_2 = 0;
    std::vector<float> edge_px;
  };
  // Over the frames.
  struct PixelNoise {
    cv::Mat1f deviation_m;  // NaN: not in every frame
    std::vector<float> blinking_m;
    int64_t blinking = 0;
    int64_t never = 0;
  };

  TargetMeter(TargetSettings settings, const RectifiedPair& pair, cv::Rect region);

  void AddResiduals(const cv::Mat1f& disparity_px, const cv::Mat1b& sigma, Measured& frame) const;
  std::optional<DisparityPlane> MeanPlane() const;
  void SetPlaneFigures(TargetQuality& quality) const;
  void SetSpatialFigures(TargetQuality& quality) const;
  void SetTemporalFigures(TargetQuality& quality) const;
  PixelNoise NoiseOfPixels() const;

  TargetSettings settings_;
  RectifiedPair pair_;
  cv::Rect region_;
  std::optional<cv::Rect> edge_;
  std::deque<Measured> frames_;  // oldest first
};

}  // namespace sprout
