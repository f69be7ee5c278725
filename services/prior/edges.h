#ifndef SPROUT_SERVICES_PRIOR_EDGES_H_
#define SPROUT_SERVICES_PRIOR_EDGES_H_

#include "common/core/disparity_image.h"
#include "services/prior/edge_hypotheses.h"
#include "services/prior/edge_judge.h"

namespace sprout {

/// Mends the prior where interpolation errs most: in triangles that span a depth edge it paints a
/// ramp that does not exist, while each pixel lies on the near surface or on the far one. The
/// judge decides for every other pixel of every other row, then for the rest; a pixel whose decided
/// neighbours all lie on one surface is on that one unheard.
///
/// @param prior  interpolation of the seeds; changed in place where there are hypotheses.
/// O(pixels); on OpenCV's threads, with the same result for any number.
void ResolveEdges(const EdgeHypotheses& hypotheses, const EdgeJudge& judge, DisparityImage& prior);

}  // namespace sprout

#endif  // SPROUT_SERVICES_PRIOR_EDGES_H_
