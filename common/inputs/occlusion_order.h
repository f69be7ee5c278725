#pragma once

#include <opencv2/core.hpp>

namespace sprout::inputs {

/// Whether what occludes has the larger disparity, as it must: the strip beside a depth edge that
/// only one image shows belongs to the farther surface. Where left and right are swapped (or both
/// images mirrored) all disparities are negated, and it seems to belong to the nearer one.
struct OcclusionOrder {
  int edges = 0;      ///< rows of depth edges that were looked at, in both images
  double share = 0;   ///< mean place of the change of brightness in these strips: 1 all at the side
                      ///< of the surface with the larger disparity, −1 all at the other side
  double sigmas = 0;  ///< share in standard deviations; 0 without an edge
};

/// Semi-global matching (OpenCV's) of a level of at most 0.2 MP, from either image.
/// @param left, right  grey, of one size.
/// @param least_px, most_px  disparities, least < most.
/// O(pixels · disparities), about 50 ms; I/O: none. The same images give the same answer.
OcclusionOrder FindOcclusionOrder(const cv::Mat1b& left, const cv::Mat1b& right, double least_px,
                                  double most_px);

}  // namespace sprout::inputs
