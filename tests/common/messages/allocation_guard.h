#ifndef SPROUT_TESTS_COMMON_MESSAGES_ALLOCATION_GUARD_H_
#define SPROUT_TESTS_COMMON_MESSAGES_ALLOCATION_GUARD_H_

#include <cstddef>

namespace sprout {

/// Watches operator new on this thread: how much memory was asked for in one piece since the guard
/// was made. Pixels of cv::Mat do not pass through it.
class AllocationGuard {
 public:
  AllocationGuard();
  static size_t largest();
};

}  // namespace sprout

#endif  // SPROUT_TESTS_COMMON_MESSAGES_ALLOCATION_GUARD_H_
