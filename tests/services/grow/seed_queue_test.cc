#include "services/grow/seed_queue.h"

#include <gtest/gtest.h>

namespace sprout {
namespace {

constexpr int32_t kLimit = 25599;  // levels of 100

TEST(SeedQueue, GivesTheSmallestCostFirst) {
  SeedQueue queue;
  queue.Reset(kLimit);
  queue.Push({1, 0, 0}, 5000);
  queue.Push({2, 0, 0}, 100);
  queue.Push({3, 0, 0}, 20000);
  EXPECT_EQ(queue.Pop()->u, 2);
  EXPECT_EQ(queue.Pop()->u, 1);
  queue.Push({4, 0, 0}, 0);  // better than all before
  EXPECT_EQ(queue.Pop()->u, 4);
  EXPECT_EQ(queue.Pop()->u, 3);
  EXPECT_FALSE(queue.Pop().has_value());
}

TEST(SeedQueue, GivesTheLastAddedFirstOnOneLevel) {
  SeedQueue queue;
  queue.Reset(kLimit);
  queue.Push({1, 0, 0}, 120);
  queue.Push({2, 0, 0}, 199);  // same level, although the cost is larger
  queue.Push({3, 0, 0}, 200);  // next level
  EXPECT_EQ(queue.Pop()->u, 2);
  EXPECT_EQ(queue.Pop()->u, 1);
  EXPECT_EQ(queue.Pop()->u, 3);
}

TEST(SeedQueue, TakesCostsBeyondTheLimitLast) {
  SeedQueue queue;
  queue.Reset(kLimit);
  queue.Push({1, 0, 0}, INT32_MAX);
  queue.Push({2, 0, 0}, 25000);
  EXPECT_EQ(queue.Pop()->u, 2);
  EXPECT_EQ(queue.Pop()->u, 1);
}

TEST(SeedQueue, IsEmptyAfterReset) {
  SeedQueue queue;
  queue.Reset(kLimit);
  queue.Push({1, 0, 0}, 5);
  queue.Reset(kLimit);
  EXPECT_FALSE(queue.Pop().has_value());
}

}  // namespace
}  // namespace sprout
