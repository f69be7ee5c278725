#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "common/core/rig.h"
#include "common/core/seed.h"
#include "common/core/tof_image.h"

namespace sprout {

// Range images are often enlarged to the size of the left image before they are stored. Each pixel
// of the sensor then counts as many that agree with each other, whatever it is worth.

/// A range image at the resolution of its sensor, or with one pixel for each of its points.
struct NativeRanges {
  TofImage tof;
  TofCamera camera;
  std::vector<int> columns, rows;  ///< of the enlarged image, in ascending order: those of `tof`

  /// The pixel of the enlarged image that a seed of `tof` comes from.
  void ToEnlarged(Seed& seed) const;
};

/// @param tof     range image of the camera's size.
/// @returns the image as it was before somebody enlarged it along both axes, at least twice by
///          repeated pixels or four times by linear interpolation; or, of the same size, before
///          points (a lidar's) were spread over the pixels around; nothing for any other image, and
///          where the sensor has fewer than eight columns or rows. O(pixels).
std::optional<NativeRanges> FindNativeRanges(const TofImage& tof, const TofCamera& camera);

}  // namespace sprout
