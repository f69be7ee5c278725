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
  // All triangles turn the same way: of those at a seed each has another neighbour behind it.
  // Inside the hull these are all; on the hull, or beside a gap, one neighbour is only ever before
  // the seed.
  for (const auto& [a, b, c] : triangles) {
    Add(a, b);
    Add(b, c);
    Add(c, a);
  }
  for (const auto& [a, b, c] : triangles) {
    AddUnknown(a, c);
    AddUnknown(b, a);
    AddUnknown(c, b);
  }
}

void SeedNeighbours::Add(int seed, int neighbour) {
  List& list = lists_[static_cast<size_t>(seed)];
  seeds_[list.begin + list.size++] = neighbour;
}

void SeedNeighbours::AddUnknown(int seed, int neighbour) {
  const std::span<const int> known = Of(seed);
  if (std::find(known.begin(), known.end(), neighbour) == known.end()) Add(seed, neighbour);
}

void Surroundings::Set(const SeedNeighbours& neighbours) {
  neighbours_ = &neighbours;
  starts_ = 0;
  seen_.assign(neighbours.size(), starts_);
}

void Surroundings::Start(std::span<const int> seeds) {
  ++starts_;
  reached_.clear();
  next_ = 0;
  for (int seed : seeds) Reach(seed);
}

void Surroundings::Widen(size_t most) {
  for (const size_t end = reached_.size(); next_ < end; ++next_) {
    for (int neighbour : neighbours_->Of(reached_[next_])) {
      if (reached_.size() >= most) return;
      Reach(neighbour);
    }
  }
}

}  // namespace sprout
