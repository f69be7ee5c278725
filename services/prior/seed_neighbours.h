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
  /// @param triangles  of these seeds. O(seeds + triangles).
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
  void KeepFirst();

  std::vector<List> lists_;
  std::vector<int> seeds_;  // all lists, one behind the other
  std::vector<int> seen_;   // the last seed in whose list a seed was seen
};

/// Seeds around some, step by step from neighbours to their neighbours. For one thread; keeps its
/// memory.
class Surroundings {
 public:
  /// @param neighbours  must outlive the calls of Widen(). O(seeds).
  void Set(const SeedNeighbours& neighbours);

  /// From these seeds...
  void Start(std::span<const int> seeds);

  /// ... to the neighbours of those that the last step reached, too.
  /// @param most  no more than that many seeds are reached in all.
  void Widen(size_t most);

  /// Each seed once, in the order of the steps.
  std::span<const int> reached() const { return reached_; }

 private:
  void Reach(int seed) {
    int& seen = seen_[static_cast<size_t>(seed)];
    if (seen == starts_) return;
    seen = starts_;
    reached_.push_back(seed);
  }

  const SeedNeighbours* neighbours_ = nullptr;
  int starts_ = 0;
  std::vector<int> seen_;  // the last start from which a seed was reached
  std::vector<int> reached_;
  size_t next_ = 0;  // of these, whose neighbours were not reached yet
};

}  // namespace sprout

#endif  // SPROUT_SERVICES_PRIOR_SEED_NEIGHBOURS_H_
