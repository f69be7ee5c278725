#ifndef SPROUT_SERVICES_DATASETS_SURFACE_RENDERER_H_
#define SPROUT_SERVICES_DATASETS_SURFACE_RENDERER_H_

#include <opencv2/core.hpp>

#include "common/core/rig.h"
#include "services/datasets/dataset.h"
#include "services/datasets/tof_samples.h"

namespace sprout::datasets {

/// Renders the surface that ground truth describes as a ToF camera elsewhere sees it.
///
/// Every pixel of a truth map becomes a small quadrilateral in space. Its corners take the mean
/// disparity of the pixels around them that belong to the same surface (within 1 px), so that
/// surfaces are closed, and end where the truth jumps. A z-buffer keeps the nearest. What the left
/// camera does not see comes from the right truth, and so does what lies in front of the left
/// surface by more than 1.5 px of disparity; elsewhere the left truth counts, since two roundings
/// of one surface would fight. A surface that neither view knows is not there: behind it the
/// camera sees what is known, else nothing.
///
/// @param rig    pair of the truth, and the ToF camera where it really stands.
/// @param truth  left map, and right map or empty.
/// @param left, right  grey images of the pair; they give the albedo, grey / 255.
/// O(image pixels + samples), one thread.
TofSamples RenderSurface(const Rig& rig, const GroundTruth& truth, const cv::Mat1b& left,
                         const cv::Mat1b& right);

}  // namespace sprout::datasets

#endif  // SPROUT_SERVICES_DATASETS_SURFACE_RENDERER_H_
