#pragma once

#include <opencv2/core.hpp>
#include <span>

#include "services/prior/triangulation/interpolation.h"

namespace sprout::prior {

/// Paints the chosen triangles into some rows of a prior, later ones over earlier ones: eqs. (P4)
/// and (P8) at the pixels of ForEachRun(). Computes several rows of a triangle, and several pixels
/// of a run, at once, with the same bytes on every CPU. O(triangles + pixels).
void PaintTriangles(std::span<const Plane> planes, std::span<const SeedTriangle> triangles,
                    std::span<const int> chosen, double edge_px, const cv::Range& rows,
                    PriorMap& map);

}  // namespace sprout::prior
