#ifndef SPROUT_SERVICES_GROW_SEED_QUEUE_H_
#define SPROUT_SERVICES_GROW_SEED_QUEUE_H_

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>

namespace sprout {

/// Priority queue of seeds. The rule that decides what comes first, part of what the stage
/// computes:
///   1. the smaller cost, after costs between 0 and the limit of acceptance have been sorted into
///      kLevels levels of equal width (what lies beyond the limit shares the last level);
///   2. on one level, the seed that was added last.
///
/// Each level is a chain of seeds. The links lie with the seeds, in the caller's memory, so the
/// queue allocates nothing. O(1) a seed.
class SeedQueue {
 public:
  using Id = uint32_t;
  static constexpr int kLevels = 256;
  static constexpr Id kNone = UINT32_MAX;

  /// @param limit  largest accepted cost.
  void Reset(int32_t limit) {
    first_.fill(kNone);
    occupied_.fill(0);
    occupied_words_ = 0;
    limit_ = limit;
    levels_per_cost_ = (kLevels << kLevelFraction) / (limit + 1);
  }

  /// LevelOf() for those who compute many at once: min(cost, limit) times this, shifted to the
  /// right by kLevelFraction.
  int32_t levels_per_cost() const { return levels_per_cost_; }
  static constexpr int kLevelFraction = 22;

  bool empty() const { return occupied_words_ == 0; }

  /// 0 to kLevels − 1.
  int LevelOf(int32_t cost) const {
    return std::min(cost, limit_) * levels_per_cost_ >> kLevelFraction;
  }

  /// @param next  the link that lies with this seed; a seed is in the queue once at a time.
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

  std::array<Id, kLevels> first_{};
  std::array<uint64_t, kLevels / 64> occupied_{};  // bit n of word w: level 64w + n holds a seed
  uint32_t occupied_words_ = 0;                    // bit w: word w is not zero
  int32_t limit_ = 0;
  int32_t levels_per_cost_ = 0;  // in fixed point
};

}  // namespace sprout

#endif  // SPROUT_SERVICES_GROW_SEED_QUEUE_H_
