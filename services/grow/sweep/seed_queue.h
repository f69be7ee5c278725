#ifndef SPROUT_SERVICES_GROW_SWEEP_SEED_QUEUE_H_
#define SPROUT_SERVICES_GROW_SWEEP_SEED_QUEUE_H_

#include <array>
#include <bit>
#include <cstdint>

#include "services/grow/paper/growth_rule.h"

namespace sprout::grow {

/// Queue of seeds in the order of growth: the lowest level first, and within a level the seed that
/// was added last.
///
/// Each level is a chain of seeds. The links lie with the seeds, in the caller's memory: one cache
/// line a visit less than a queue that holds seeds itself. O(1) a seed.
class SeedQueue {
 public:
  using Id = uint32_t;
  static constexpr Id kNone = UINT32_MAX;

  SeedQueue() { first_.fill(kNone); }

  bool empty() const { return occupied_words_ == 0; }

  /// @param level  0 to kLevels − 1.
  /// @param next   the link that lies with this seed; a seed is in the queue once at a time.
  void Push(Id seed, int level, Id& next) {
    next = first_[static_cast<size_t>(level)];
    first_[static_cast<size_t>(level)] = seed;
    occupied_[static_cast<size_t>(level / 64)] |= uint64_t{1} << (level % 64);
    occupied_words_ |= 1u << (level / 64);
  }

  /// The first seed. @pre not empty.
  Id Top() const { return first_[static_cast<size_t>(BestLevel())]; }

  /// Takes the first seed out. @param next  its link. @pre not empty.
  void Pop(Id next) {
    const int level = BestLevel();
    first_[static_cast<size_t>(level)] = next;
    uint64_t& word = occupied_[static_cast<size_t>(level / 64)];
    word &= ~(uint64_t{next == kNone} << (level % 64));
    occupied_words_ &= ~(static_cast<uint32_t>(word == 0) << (level / 64));
  }

 private:
  int BestLevel() const {
    const int word = std::countr_zero(occupied_words_);
    return word * 64 + std::countr_zero(occupied_[static_cast<size_t>(word)]);
  }

  std::array<Id, kLevels> first_;
  std::array<uint64_t, kLevels / 64> occupied_{};  // bit n of word w: level 64w + n holds a seed
  uint32_t occupied_words_ = 0;                    // bit w: word w is not zero
};

}  // namespace sprout::grow

#endif  // SPROUT_SERVICES_GROW_SWEEP_SEED_QUEUE_H_
