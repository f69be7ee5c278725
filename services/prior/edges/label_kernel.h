#pragma once

#include <opencv2/core.hpp>
#include <span>

#include "services/prior/edges/edge_surfaces.h"

namespace sprout::prior {

/// Enters the labels of the chosen triangles, eq. (P5), in some rows, later ones over earlier ones,
/// where their surfaces are at least `least_gap_px` apart. Computes several pixels of a row at
/// once, with the same bytes on every CPU. O(triangles + pixels).
void PaintEdgeLabels(std::span<const EdgeTriangle> edges, std::span<const int> chosen,
                     std::span<const Plane> planes, float least_gap_px, const cv::Range& rows,
                     EdgeLabels& labels);

}  // namespace sprout::prior
