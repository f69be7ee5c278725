#include "tests/common/messages/allocation_guard.h"

#include <algorithm>
#include <cstdlib>
#include <new>

namespace {
thread_local size_t largest_allocation = 0;
}  // namespace

void* operator new(size_t size) {
  largest_allocation = std::max(largest_allocation, size);
  if (void* memory = std::malloc(std::max<size_t>(size, 1))) return memory;
  throw std::bad_alloc();
}
void* operator new[](size_t size) { return operator new(size); }
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, size_t) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory, size_t) noexcept { std::free(memory); }

namespace sprout {

AllocationGuard::AllocationGuard() { largest_allocation = 0; }
size_t AllocationGuard::largest() { return largest_allocation; }

}  // namespace sprout
