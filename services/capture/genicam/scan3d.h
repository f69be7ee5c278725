#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <span>

#include "common/core/result.h"
#include "common/core/tof_image.h"
#include "services/capture/genicam/pixels.h"

namespace sprout::capture {

/// How a device's numbers become metres (GenICam SFNC, 3D Scan Control): the coordinate C is
///   (number · scale + offset) · unit_m.
struct Scan3d {
  double scale = 1;      ///< Scan3dCoordinateScale of coordinate C
  double offset = 0;     ///< Scan3dCoordinateOffset of coordinate C
  double unit_m = 1e-3;  ///< of Scan3dDistanceUnit, m
  /// The number that says "no return" (Scan3dInvalidDataValue), where Scan3dInvalidDataFlag is set;
  /// of integers of 16 bits 65535 says so, too.
  std::optional<double> invalid;
  /// C is the range along the ray (Scan3dCoordinateSystem = Spherical), not z.
  bool is_range = false;
};

/// A ToF camera's measurement: C of every pixel, 0 where there is no return, and the amplitude.
/// Call RangesToDepths() afterwards if scan3d.is_range. A copy, independent of the payload.
///
/// One part holds C: Coord3D_C16, _C32f, _ABC16, _ABC32f or _ABCY16, or Mono16 if no other part
/// can. The amplitude is a part with an image (Mono16, Mono8), else the Y beside C, else the
/// confidence, else empty; a confidence of 0 means no return. The error names what is missing or
/// does not fit together. O(pixels).
Result<TofImage> ToTofImage(std::span<const PayloadPart> parts, const Scan3d& scan3d);

/// Converts ranges along the ray to z.
/// @param range_per_depth  RangePerDepth() of the camera's lens, of the image's size.
void RangesToDepths(TofImage& image, const cv::Mat1d& range_per_depth);

}  // namespace sprout::capture
