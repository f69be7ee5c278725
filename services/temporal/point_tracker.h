#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "services/temporal/image_pyramid.h"

namespace sprout::temporal {

/// A point of the scene in two images, px of the whole images.
struct TrackedPoint {
  cv::Point2d before;
  cv::Point2d after;
};

/// The strongest corner in each of 32×20 cells of an image, so that no object has most of them: the
/// pixel with the largest smaller eigenvalue of the structure tensor (Shi and Tomasi, CVPR 1994),
/// where that says that there is texture in all directions.
/// @returns px of the pyramid's finest level. O(pixels).
std::vector<cv::Point> FindCorners(const ImagePyramid& pyramid);

/// Finds corners of one image again in another one, coarse to fine (Lucas and Kanade, IJCAI 1981;
/// Bouguet's pyramids), whatever the brightness of either. What is not found again on the way back
/// is left out. Grey values are summed in whole numbers, so neither threads nor vectors change a
/// bit. About 5 µs a corner.
/// @param before, after  of images of one size.
std::vector<TrackedPoint> TrackCorners(const ImagePyramid& before, const ImagePyramid& after);

}  // namespace sprout::temporal
