#include "services/prior/seed_neighbours.h"

#include <algorithm>
#include <utility>

namespace sprout {

void SeedNeighbours::Find(size_t seeds, std::span<const SeedTriangle> triangles) {
  lists_.assign(seeds, {});
  for (const SeedTriangle& triangle : triangles) {
    for (int seed : triangle) lists_[static_cast<size_t>(seed)].begin += 2;  // room it may need
  }
  size_t end = 0;
  for (List& list : lists_) end += std::exchange(list.begin, end);
  seeds_.resize(end);
  for (const auto& [a, b, c] : triangles) {
    Add(a, b, c);
    Add(b, c, a);
    Add(c, a, b);
  }
}

void SeedNeighbours::Add(int seed, int one, int other) {
  List& list = lists_[static_cast<size_t>(seed)];
  for (int neighbour : {one, other}) {
    const std::span<const int> known = Of(seed);
    if (std::find(known.begin(), known.end(), neighbour) != known.end()) continue;
    seeds_[list.begin + list.size++] = neighbour;
  }
}

}  // namespace sprout
