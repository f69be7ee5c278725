#ifndef SPROUT_SERVICES_PRIOR_CENSUS_H_
#define SPROUT_SERVICES_PRIOR_CENSUS_H_

#include <opencv2/core.hpp>

namespace sprout {

/// The census transform (Zabih and Woodfill, ECCV 1994): for each pixel a bit for each of the eight
/// around it, set if that one is darker. It does not change with the exposure of a camera, and says
/// where edges run even if they are faint. Pixels on the border have none.
///
/// @param codes  is overwritten; its memory is used again when the size is the same.
/// O(pixels); on OpenCV's threads.
void CensusTransform(const cv::Mat1b& image, cv::Mat1b& codes);

}  // namespace sprout

#endif  // SPROUT_SERVICES_PRIOR_CENSUS_H_
