#pragma once

#include "common/core/disparity_image.h"
#include "common/core/planar_scan.h"
#include "common/core/pose.h"
#include "common/core/result.h"
#include "common/core/rig.h"

namespace sprout::depth {

/// What a scan takes from a map.
struct ScanBand {
  double min_height_m = 0;  ///< z in the robot's frame, both ends included
  double max_height_m = 0;
  double step_deg = 0.25;  ///< from one direction to the next, 0.05 to 10
};

/// The left camera as a robot's frame: at its place, x forward, y left, z up.
Pose LevelFromLeft();

/// The nearest point of each direction within a band of heights. The scan stands at the left
/// camera's place, horizontally in the robot's frame: ranges count from the camera, angles from the
/// robot's x axis to its left. A point belongs to the direction that is nearest to its own.
/// Directions are those that the image sees at the height of the camera; where they hold no point
/// of the band the range is infinite: nothing was seen there, which does not say that it is free.
/// No trigonometric function, so the same bytes everywhere. O(pixels).
///
/// @param pair  of the map's size.
/// @param base_from_left  pose of the left rectified camera in the robot's frame.
/// @returns an error when the image shows what is straight above or below the camera: then it has
/// no first and no last direction.
Result<PlanarScan> ScanOf(const DisparityImage& map, const RectifiedPair& pair,
                          const Pose& base_from_left, const ScanBand& band);

}  // namespace sprout::depth
