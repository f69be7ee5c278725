#include "tests/common/testing/allocation_guard.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <thread>
#include <vector>

namespace sprout {
namespace {

TEST(AllocationGuard, SeesNewAndOpenCv) {
  const AllocationGuard guard;
  { const std::vector<int> values(10); }
  EXPECT_EQ(guard.count(), 1);
  { const cv::Mat1b image(10, 10); }
  EXPECT_GE(guard.count(), 2);  // the pixels, and what it keeps about them
}

TEST(AllocationGuard, SeesOtherThreads) {
  int64_t in_thread = 0;
  std::thread([&] {
    const AllocationGuard guard;
    const std::vector<int> values(10);
    in_thread = guard.count();
  }).join();
  EXPECT_EQ(in_thread, 1);
  const AllocationGuard guard;
  std::thread([] { const std::vector<int> values(10); }).join();
  EXPECT_GE(guard.count(), 1);
}

TEST(AllocationGuard, SeesTheLargestOfThisThread) {
  const AllocationGuard guard;
  { const std::vector<char> values(1000); }
  { const std::vector<char> values(10); }
  std::thread([] { const std::vector<char> values(5000); }).join();
  EXPECT_EQ(guard.largest(), 1000U);
}

TEST(AllocationGuard, CountsNothingWhereNothingIs) {
  cv::Mat1b image(10, 10);
  const AllocationGuard guard;
  const cv::Mat1b rows = image.rowRange(2, 5);
  image.create(10, 10);
  EXPECT_EQ(guard.count(), 0);
}

}  // namespace
}  // namespace sprout
