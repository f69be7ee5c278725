#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <vector>

#include "common/core/disparity_image.h"
#include "common/core/rig.h"
#include "common/core/seed.h"
#include "common/core/tof_image.h"

namespace sprout {

/// The values that a colour scale covers, min < max; unit of the values (px or m).
struct ValueRange {
  double min = 0;
  double max = 1;

  bool operator==(const ValueRange&) const = default;
};

/// Colour (BGR) of a pixel without a value: nearly black, darker than every colour of the scale.
inline const cv::Vec3b kNoValueColor{14, 12, 12};

/// Colour (BGR) of a value: OpenCV's TURBO from blue (range.min) to red (range.max) without its
/// dark ends, which would look like pixels without a value. Values outside the range get the colour
/// of its nearer end; NaN and infinities get kNoValueColor. O(1).
cv::Vec3b ColorOf(double value, const ValueRange& range);

/// ColorOf() for every pixel. O(pixels).
cv::Mat3b Colorize(const cv::Mat1f& values, const ValueRange& range);

/// Position of a depth between the far end of the range (0) and the near one (1): linear in
/// 1/depth, as disparity is. Outside the range it is outside [0, 1].
/// @param range_m  0 < min < max; max may be infinite.
double ShareOfDepth(double depth_m, const ValueRange& range_m);

/// Colour (BGR) of a depth: near is red and far is blue, as a large and a small disparity are. With
/// the DepthRange() of a disparity range it is the same colour as that of the disparity. NaN,
/// infinities and depths ≤ 0 get kNoValueColor. O(1).
cv::Vec3b ColorOfDepth(double depth_m, const ValueRange& range_m);

/// ColorOfDepth() for every pixel. O(pixels).
cv::Mat3b ColorizeDepth(const cv::Mat1f& depth_m, const ValueRange& range_m);

/// The smallest of 1, 2 and 5 times a power of ten that is ≥ `at_least` > 0.
double RoundStep(double at_least);

/// A range that shows nearly all values and ignores a few outliers: their 1st to 99th percentile,
/// rounded outward to a round step of at most a tenth of that span. NaN and infinities do not
/// count. Equal values give that value ± 1 (± a thousandth of a value beyond 1000), no values give
/// [0, 1]. O(n).
ValueRange RobustRange(std::vector<float> values);

/// One range (px) for several disparity maps and the seeds, so that their pictures share a scale.
/// O(pixels).
ValueRange DisparityRange(std::span<const DisparityImage> maps, std::span<const Seed> seeds);

/// Depths (m) of a range of disparities (px); max is infinite when disparities of the range are at
/// infinity or beyond.
/// @pre range_px.max lies in front of the cameras, see InFront().
ValueRange DepthRange(const RectifiedPair& pair, const ValueRange& range_px);

/// The part of a range of disparities (px) that corresponds to depths, so that disparities and
/// depths can share colours; nothing when there is none.
std::optional<ValueRange> InFront(const RectifiedPair& pair, const ValueRange& range_px);

/// Range (m) of a ToF image's returns, min > 0. O(pixels).
ValueRange DepthRange(const TofImage& tof);

/// Depth in m with NaN wherever there is no return, see IsReturn(). O(pixels).
cv::Mat1f ReturnsOnly(const cv::Mat1f& depth_m);

}  // namespace sprout
