#include "common/app/compute.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <memory>

namespace sprout {
namespace {

long PageFaults() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_minflt;
}

// As a stage does for a frame: maps of 2 MP, written once and freed.
long FaultsOfAFrame() {
  constexpr size_t kMap = size_t{8} << 20;
  const long before = PageFaults();
  std::unique_ptr<char[]> maps[4];
  for (auto& map : maps) {
    map = std::make_unique_for_overwrite<char[]>(kMap);
    volatile char* const bytes = map.get();
    for (size_t i = 0; i < kMap; ++i) bytes[i] = 1;
  }
  return PageFaults() - before;
}

TEST(TouchMemory, LeavesNoPageFaultsToTheFirstFrame) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) || !defined(__GLIBC__)
  GTEST_SKIP() << "needs the allocator of the C library";
#endif
  KeepMemory();
  const long before = PageFaults();
  TouchMemory(size_t{64} << 20);
  EXPECT_GT(PageFaults() - before, 30);  // 16384 pages, or 32 huge ones
  EXPECT_LT(FaultsOfAFrame(), 10);
}

}  // namespace
}  // namespace sprout
