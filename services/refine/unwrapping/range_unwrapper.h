#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "common/core/tof_image.h"
#include "common/geometry/projection.h"

namespace sprout::refine {

/// The constants of RangeUnwrapper. NOTES.md has what was measured.
struct UnwrappingRules {
  /// Half the side of the windows that are compared, px. By trial: windows of 5×5 px do not tell
  /// the two places apart.
  static constexpr int kRadius = 4;
  /// Variance of grey values without texture: noise of a camera, 2 grey levels.
  static constexpr double kNoise = 4;
  /// Tangent of the slant up to which ToF pixels are one surface, 68°. Measured: at 76° wrapped and
  /// other surfaces run into one.
  static constexpr double kSteepest = 2.5;
  /// Fewest points of a surface that is decided on: fewer show no mean. By trial.
  static constexpr int kMinPoints = 30;
  /// Mean preference of a surface that is far. Measured: the correlation's mean is up to 0.05 at
  /// the wrong place, and 0.12 or more at a surface's own.
  static constexpr double kClearly = 0.1;
  /// Mean preference above which neither place can be trusted: what the wrong place reaches.
  static constexpr double kUnclearly = 0.05;
  /// Share of the median albedo: a surface below it is blacker than real ones, which have 3 to 90
  /// %.
  static constexpr double kMinAlbedo = 1 / 30.0;
};

/// Finds surfaces beyond the unambiguous range of a phase camera, which come back that range too
/// near. A surface of the ToF image lies either where it says or one range farther. The images
/// decide between the two by eq. (U1) of the README: at its true place the windows around its
/// points correlate. Where they have no texture, the amplitude decides, which falls with the square
/// of the range: a surface that is too black to be so near is far.
class RangeUnwrapper {
 public:
  /// Moves the points of such surfaces to where they are, and removes those of surfaces that the
  /// images prefer to be far, but not clearly. A surface with too few points stays as it is, as
  /// does one for which neither images nor amplitude decide. The order of the points stays.
  /// @param left, right  rectified pair of the calibrated size, grey.
  /// @param tof          of the calibrated size.
  /// @param range_m      unambiguous range, m along the ray; > 0.
  /// @param points       of `tof`, projected, row by row.
  /// @returns how many points were removed.
  /// O(ToF pixels), about 1 µs each; on OpenCV's threads, with the same result for any number.
  /// Keeps its memory.
  int32_t Apply(const cv::Mat1b& left, const cv::Mat1b& right, const TofImage& tof,
                const TofProjector& projector, double range_m, std::vector<ProjectedPoint>& points);

  /// The range image as Apply() takes it: surfaces that are far are one range farther, and those
  /// whose points it removes are 0. What else looks at ranges must not see wrapped ones.
  TofImage Unwrap(const cv::Mat1b& left, const cv::Mat1b& right, const TofImage& tof,
                  const TofProjector& projector, double range_m);

 private:
  // What becomes of a surface.
  enum class Verdict : uint8_t { kNear, kFar, kUnsure };

  void FindMedianAlbedo(std::span<const ProjectedPoint> points);
  // @param step_m  most that ranges of one surface differ from pixel to pixel.
  void FindSurfaces(double step_m);
  Verdict Judge(const std::vector<cv::Point>& surface) const;

  cv::Mat1d ranges_m_;    // of the ToF pixels; NaN = no point
  cv::Mat1f preference_;  // of the images for the far place: −1 to 1
  cv::Mat1f albedo_;      // amplitude · range², as good as an albedo; 0 = no amplitude
  float median_albedo_ = 0;
  cv::Mat1b verdicts_;  // of the surfaces, at their ToF pixels
  cv::Mat1b seen_;      // in a surface that was found
  std::vector<float> albedos_;
  std::vector<cv::Point> surface_;
  std::vector<ProjectedPoint> far_;  // the points, if they are far
};

}  // namespace sprout::refine
