#ifndef SPROUT_SERVICES_GROW_SEED_QUEUE_H_
#define SPROUT_SERVICES_GROW_SEED_QUEUE_H_

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

namespace sprout {

/// A seed on its way through the queue: whole pixels.
struct QueuedSeed {
  int16_t u;
  int16_t v;
  int16_t disparity;
};

/// Priority queue of seeds. The rule that decides what comes first, part of what the stage
/// computes:
///   1. the smaller cost, after costs between 0 and the limit of acceptance have been sorted into
///      kLevels levels of equal width (what lies beyond the limit shares the last level);
///   2. on one level, the seed that was added last.
/// O(1) a seed. Keeps its memory when it runs empty.
class SeedQueue {
 public:
  static constexpr int kLevels = 256;

  /// @param limit  largest accepted cost.
  void Reset(int32_t limit) {
    for (auto& level : levels_) level.clear();
    limit_ = limit;
    best_ = kLevels;
  }

  void Push(QueuedSeed seed, int32_t cost) {
    const int level =
        std::min(static_cast<int>(int64_t{cost} * kLevels / (int64_t{limit_} + 1)), kLevels - 1);
    levels_[static_cast<size_t>(level)].push_back(seed);
    best_ = std::min(best_, level);
  }

  /// Takes the first seed out; nothing when the queue is empty.
  std::optional<QueuedSeed> Pop() {
    while (best_ < kLevels && levels_[static_cast<size_t>(best_)].empty()) ++best_;
    if (best_ == kLevels) return std::nullopt;
    auto& level = levels_[static_cast<size_t>(best_)];
    const QueuedSeed seed = level.back();
    level.pop_back();
    return seed;
  }

 private:
  std::array<std::vector<QueuedSeed>, kLevels> levels_;
  int32_t limit_ = 0;
  int best_ = kLevels;  // no level below this one holds a seed
};

}  // namespace sprout

#endif  // SPROUT_SERVICES_GROW_SEED_QUEUE_H_
