#include "tests/common/testing/allocation_guard.h"

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <new>
#include <opencv2/core.hpp>

namespace {

std::atomic<int64_t> allocations{0};
thread_local size_t largest_allocation = 0;

// OpenCV's own allocator, counted.
class CountingAllocator : public cv::MatAllocator {
 public:
  cv::UMatData* allocate(int dims, const int* sizes, int type, void* data, size_t* step,
                         cv::AccessFlag flags, cv::UMatUsageFlags usage) const override {
    if (data == nullptr) ++allocations;
    cv::UMatData* memory = standard_->allocate(dims, sizes, type, data, step, flags, usage);
    if (data == nullptr) largest_allocation = std::max(largest_allocation, memory->size);
    memory->currAllocator = memory->prevAllocator = standard_;
    return memory;
  }
  bool allocate(cv::UMatData* data, cv::AccessFlag access,
                cv::UMatUsageFlags usage) const override {
    return standard_->allocate(data, access, usage);
  }
  void deallocate(cv::UMatData* data) const override { standard_->deallocate(data); }

 private:
  cv::MatAllocator* standard_ = cv::Mat::getStdAllocator();
};

}  // namespace

// Not inlined, or GCC takes malloc and free for a mismatch of new and delete.
[[gnu::noinline]] void* operator new(size_t size) {
  ++allocations;
  largest_allocation = std::max(largest_allocation, size);
  if (void* memory = std::malloc(std::max<size_t>(size, 1))) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, size_t) noexcept { std::free(memory); }
void* operator new[](size_t size) { return operator new(size); }
void operator delete[](void* memory) noexcept { operator delete(memory); }
void operator delete[](void* memory, size_t) noexcept { operator delete(memory); }

namespace sprout {

AllocationGuard::AllocationGuard() {
  static CountingAllocator counting;
  cv::Mat::setDefaultAllocator(&counting);
  largest_allocation = 0;
  before_ = allocations;
}

AllocationGuard::~AllocationGuard() { cv::Mat::setDefaultAllocator(cv::Mat::getStdAllocator()); }

int64_t AllocationGuard::count() const { return allocations - before_; }

size_t AllocationGuard::largest() { return largest_allocation; }

}  // namespace sprout
