#ifndef SPROUT_SERVICES_PRIOR_SEED_NEIGHBOURS_H_
#define SPROUT_SERVICES_PRIOR_SEED_NEIGHBOURS_H_

#include <cstddef>
#include <span>
#include <vector>

#include "services/prior/delaunay.h"

namespace sprout {

/// For each seed those that it shares a triangle with. Keeps its memory from frame to frame.
class SeedNeighbours {
 public:
  /// @param seeds      how many there are.
  /// @param triangles  of these seeds. O(triangles).
  void Find(size_t seeds, std::span<const SeedTriangle> triangles);

  /// Each neighbour once. Valid until the next Find().
  std::span<const int> Of(int seed) const {
    const List& list = lists_[static_cast<size_t>(seed)];
    return {seeds_.data() + list.begin, list.size};
  }

  size_t size() const { return lists_.size(); }

 private:
  struct List {
    size_t begin = 0;
    size_t size = 0;
  };

  void Add(int seed, int neighbour);
  void AddUnknown(int seed, int neighbour);

  std::vector<List> lists_;
  std::vector<int> seeds_;  // all lists, one behind the other
};

}  // namespace sprout

#endif  // SPROUT_SERVICES_PRIOR_SEED_NEIGHBOURS_H_
