#ifndef SPROUT_SERVICES_REFINE_RANGE_SURFACE_PATCHES_H_
#define SPROUT_SERVICES_REFINE_RANGE_SURFACE_PATCHES_H_

#include <cstdint>
#include <vector>

#include "services/refine/range/range_nodes.h"

namespace sprout::refine {

/// Clears the flags of nodes that have fewer than `fewest` flagged nodes side by side on one
/// surface. Call nodes.Link() before.
inline void KeepPatches(const RangeNodes& nodes, size_t fewest, std::vector<uint8_t>& flags) {
  std::vector<uint8_t> todo = flags;
  std::vector<size_t> patch;
  for (size_t i = 0; i < flags.size(); ++i) {
    if (todo[i] == 0) continue;
    patch = {i};
    todo[i] = 0;
    for (size_t next = 0; next < patch.size(); ++next) {
      for (const uint32_t other : nodes.SurfaceAround(patch[next])) {
        if (todo[other] == 0) continue;
        todo[other] = 0;
        patch.push_back(other);
      }
    }
    if (patch.size() >= fewest) continue;
    for (const size_t node : patch) flags[node] = 0;
  }
}

}  // namespace sprout::refine

#endif  // SPROUT_SERVICES_REFINE_RANGE_SURFACE_PATCHES_H_
