#ifndef SPROUT_SERVICES_PRIOR_EDGES_OUTLINE_H_
#define SPROUT_SERVICES_PRIOR_EDGES_OUTLINE_H_

#include <span>

#include "common/core/seed.h"
#include "services/prior/triangulation/triangulation.h"

namespace sprout::prior {

/// Takes flat triangles off the hull, so that it follows the outermost seeds: one seed that lies
/// further out than a whole row of others spans a side over all of them. A triangle goes if its
/// side on the hull is longer than `longest_px`, its third corner less than `deepest_px` from that
/// side, and not on the hull; then its other two sides are looked at. The neighbours stay.
///
/// @param seeds  that were triangulated.
/// O(triangles); one thread.
void TakeOffFlatTriangles(std::span<const Seed> seeds, double longest_px, double deepest_px,
                          Triangulation& triangulation);

}  // namespace sprout::prior

#endif  // SPROUT_SERVICES_PRIOR_EDGES_OUTLINE_H_
