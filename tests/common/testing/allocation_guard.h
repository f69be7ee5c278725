#pragma once

#include <cstddef>
#include <cstdint>

namespace sprout {

/// Watches what is allocated while it lives. A program that links it has its operators new and
/// delete. Memory that C code takes with malloc() passes by unseen.
class AllocationGuard {
 public:
  AllocationGuard();
  ~AllocationGuard();
  AllocationGuard(const AllocationGuard&) = delete;
  AllocationGuard& operator=(const AllocationGuard&) = delete;

  /// How many pieces of memory were asked for, by any thread: by operator new, and for pixels of
  /// cv::Mat.
  int64_t count() const;

  /// The largest such piece that this thread asked for, bytes.
  static size_t largest();

 private:
  int64_t before_ = 0;
};

}  // namespace sprout
