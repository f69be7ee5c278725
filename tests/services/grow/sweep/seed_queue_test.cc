#include <gtest/gtest.h>

#include <array>

#include "services/grow/sweep/growth_band.h"

namespace sprout::grow {
namespace {

// A queue with the links of a few seeds.
class SeedQueueTest : public testing::Test {
 protected:
  void Push(SeedQueue::Id seed, int level) { queue_.Push(seed, level, links_.at(seed)); }

  SeedQueue::Id Pop() {
    const SeedQueue::Id seed = queue_.Top();
    queue_.Pop(links_.at(seed));
    return seed;
  }

  SeedQueue queue_;
  std::array<SeedQueue::Id, 8> links_{};
};

TEST_F(SeedQueueTest, GivesTheSmallestLevelFirst) {
  Push(1, 70);
  Push(2, 1);
  Push(3, 255);
  EXPECT_EQ(Pop(), 2);
  EXPECT_EQ(Pop(), 1);
  Push(4, 0);  // better than all before
  EXPECT_EQ(Pop(), 4);
  EXPECT_EQ(Pop(), 3);
  EXPECT_TRUE(queue_.empty());
}

TEST_F(SeedQueueTest, GivesTheLastAddedFirstOnOneLevel) {
  Push(1, 64);
  Push(2, 64);
  Push(3, 65);
  EXPECT_EQ(Pop(), 2);
  EXPECT_EQ(Pop(), 1);
  EXPECT_EQ(Pop(), 3);
}

TEST_F(SeedQueueTest, CanTakeASeedAgain) {
  Push(1, 5);
  EXPECT_EQ(Pop(), 1);
  Push(1, 200);
  Push(2, 5);
  EXPECT_EQ(Pop(), 2);
  EXPECT_EQ(Pop(), 1);
}

}  // namespace
}  // namespace sprout::grow
