#ifndef SPROUT_SERVICES_REFINE_RANGE_SURFACE_PATCHES_H_
#define SPROUT_SERVICES_REFINE_RANGE_SURFACE_PATCHES_H_

#include <cstdint>
#include <vector>

#include "services/refine/range/range_nodes.h"

namespace sprout::refine {

/// Calls visit(index of a node) for the nodes within `reach` cells that share the node's surface,
/// itself included.
template <typename Visit>
void ForSurfaceAround(const RangeNodes& nodes, const RangeNode& node, int reach,
                      const Visit& visit) {
  for (int y = -reach; y <= reach; ++y) {
    for (int x = -reach; x <= reach; ++x) {
      const int other = nodes.At(node.cell.x + x, node.cell.y + y);
      if (other < 0) continue;
      const auto index = static_cast<size_t>(other);
      if ((x == 0 && y == 0) || ShareSurface(node, nodes.nodes()[index])) visit(index);
    }
  }
}

/// Clears the flags of nodes that have fewer than `fewest` flagged nodes side by side on one
/// surface.
inline void KeepPatches(const RangeNodes& nodes, size_t fewest, std::vector<uint8_t>& flags) {
  std::vector<uint8_t> todo = flags;
  std::vector<size_t> patch;
  for (size_t i = 0; i < flags.size(); ++i) {
    if (todo[i] == 0) continue;
    patch = {i};
    todo[i] = 0;
    for (size_t next = 0; next < patch.size(); ++next) {
      ForSurfaceAround(nodes, nodes.nodes()[patch[next]], 1, [&](size_t other) {
        if (todo[other] == 0) return;
        todo[other] = 0;
        patch.push_back(other);
      });
    }
    if (patch.size() >= fewest) continue;
    for (const size_t node : patch) flags[node] = 0;
  }
}

}  // namespace sprout::refine

#endif  // SPROUT_SERVICES_REFINE_RANGE_SURFACE_PATCHES_H_
