#include "services/grow/seed_queue.h"

#include <gtest/gtest.h>

#include <array>

namespace sprout {
namespace {

constexpr int32_t kLimit = 25599;  // levels of 100

// A queue with the links of a few seeds.
class SeedQueueTest : public testing::Test {
 protected:
  SeedQueueTest() { queue_.Reset(kLimit); }

  void Push(SeedQueue::Id seed, int32_t cost) {
    queue_.Push(seed, queue_.LevelOf(cost), links_.at(seed));
  }

  SeedQueue::Id Pop() {
    const SeedQueue::Id seed = queue_.Top();
    queue_.Pop(links_.at(seed));
    return seed;
  }

  SeedQueue queue_;
  std::array<SeedQueue::Id, 8> links_{};
};

TEST_F(SeedQueueTest, GivesTheSmallestCostFirst) {
  Push(1, 5000);
  Push(2, 100);
  Push(3, 20000);
  EXPECT_EQ(Pop(), 2);
  EXPECT_EQ(Pop(), 1);
  Push(4, 0);  // better than all before
  EXPECT_EQ(Pop(), 4);
  EXPECT_EQ(Pop(), 3);
  EXPECT_TRUE(queue_.empty());
}

TEST_F(SeedQueueTest, GivesTheLastAddedFirstOnOneLevel) {
  Push(1, 120);
  Push(2, 199);  // same level, although the cost is larger
  Push(3, 220);  // next level
  EXPECT_EQ(Pop(), 2);
  EXPECT_EQ(Pop(), 1);
  EXPECT_EQ(Pop(), 3);
}

TEST_F(SeedQueueTest, TakesCostsBeyondTheLimitWithTheLastLevel) {
  Push(1, INT32_MAX);
  Push(2, 25500);
  EXPECT_EQ(Pop(), 2);
  EXPECT_EQ(Pop(), 1);
}

TEST_F(SeedQueueTest, CanTakeASeedAgain) {
  Push(1, 5);
  EXPECT_EQ(Pop(), 1);
  Push(1, 20000);
  Push(2, 5);
  EXPECT_EQ(Pop(), 2);
  EXPECT_EQ(Pop(), 1);
}

TEST_F(SeedQueueTest, IsEmptyAfterReset) {
  Push(1, 5);
  queue_.Reset(kLimit);
  EXPECT_TRUE(queue_.empty());
}

}  // namespace
}  // namespace sprout
