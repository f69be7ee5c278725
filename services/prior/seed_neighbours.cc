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
    Add(a, c);
    Add(b, a);
    Add(c, b);
  }
  KeepFirst();
}

void SeedNeighbours::Add(int seed, int neighbour) {
  List& list = lists_[static_cast<size_t>(seed)];
  seeds_[list.begin + list.size++] = neighbour;
}

// Of a neighbour that is in a list twice.
void SeedNeighbours::KeepFirst() {
  seen_.assign(lists_.size(), -1);
  for (size_t seed = 0; seed < lists_.size(); ++seed) {
    List& list = lists_[seed];
    int* const neighbours = seeds_.data() + list.begin;
    const auto end = std::remove_if(neighbours, neighbours + list.size, [&](int neighbour) {
      const auto lister = static_cast<int>(seed);
      return std::exchange(seen_[static_cast<size_t>(neighbour)], lister) == lister;
    });
    list.size = static_cast<size_t>(end - neighbours);
  }
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
