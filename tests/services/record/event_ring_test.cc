#include "services/record/event_ring.h"

#include <gtest/gtest.h>

#include "tests/services/record/make_event.h"

namespace sprout::record {
namespace {

using std::chrono::seconds;

constexpr size_t kEnoughBytes = 1'000'000;

TEST(EventRing, KeepsTheLastSeconds) {
  EventRing ring(seconds(3), kEnoughBytes);
  for (int i = 0; i <= 10; ++i) ring.Add(MakeRecorded(i));
  ASSERT_EQ(ring.events().size(), 4U);
  EXPECT_EQ(ring.events().front().utime, 7'000'000);
  EXPECT_EQ(ring.events().back().utime, 10'000'000);
  EXPECT_EQ(ring.not_fitted(), 0);
}

TEST(EventRing, CountsWhatDoesNotFit) {
  const size_t one = MakeRecorded(0).memory();
  EventRing ring(seconds(100), 3 * one);
  for (int i = 0; i < 10; ++i) ring.Add(MakeRecorded(i));
  ASSERT_EQ(ring.events().size(), 3U);
  EXPECT_EQ(ring.events().front().utime, 7'000'000);
  EXPECT_EQ(ring.not_fitted(), 7);
}

TEST(EventRing, SurvivesAMessageLargerThanItself) {
  EventRing ring(seconds(3), 1000);
  ring.Add(MakeRecorded(0));
  ring.Add(MakeRecorded(1, 5000));
  EXPECT_TRUE(ring.events().empty());
  EXPECT_EQ(ring.not_fitted(), 2);
  ring.Add(MakeRecorded(2));
  EXPECT_EQ(ring.events().size(), 1U);
}

TEST(EventRing, GoesByTheClockThatNobodySets) {
  EventRing ring(seconds(3), kEnoughBytes);
  for (int i = 0; i <= 10; ++i) {
    RecordedEvent event = MakeRecorded(i);
    event.utime = i < 5 ? 3'600'000'000 + i : i;  // set back by an hour meanwhile
    ring.Add(std::move(event));
  }
  EXPECT_EQ(ring.events().size(), 4U);
}

using std::chrono::milliseconds;

TEST(EventQueue, RefusesWhatDoesNotFitButATrigger) {
  EventQueue queue(2 * MakeRecorded(0).memory());
  EXPECT_TRUE(queue.Put({.event = MakeRecorded(0)}));
  EXPECT_TRUE(queue.Put({.event = MakeRecorded(1)}));
  EXPECT_FALSE(queue.Put({.event = MakeRecorded(2)}));
  EXPECT_TRUE(
      queue.Put({.kind = QueuedEvent::Kind::kTrigger, .event = MakeRecorded(3), .trigger = "me"}));
  EXPECT_EQ(queue.size(), 3U);
  EXPECT_EQ(queue.TakeWithin(milliseconds(0))->event.utime, 0);
  EXPECT_EQ(queue.TakeWithin(milliseconds(0))->event.utime, 1'000'000);
  EXPECT_EQ(queue.TakeWithin(milliseconds(0))->trigger, "me");
  EXPECT_EQ(queue.bytes(), 0U);
  EXPECT_TRUE(queue.Put({.event = MakeRecorded(4)}));
}

TEST(EventQueue, ManyTriggersTakeNoMoreMemoryThanFits) {
  const size_t room = 3 * MakeRecorded(0).memory();
  EventQueue queue(room);
  EXPECT_TRUE(queue.Put({.event = MakeRecorded(0)}));
  for (int i = 1; i <= 100; ++i) {
    EXPECT_TRUE(queue.Put({.kind = QueuedEvent::Kind::kTrigger,
                           .event = MakeRecorded(i),
                           .trigger = std::to_string(i)}));
  }
  EXPECT_LE(queue.bytes(), room);
  std::string newest;
  while (auto event = queue.TakeWithin(milliseconds(0))) newest = event->trigger;
  EXPECT_EQ(newest, "100");
}

TEST(EventQueue, GivesOutWhatIsLeftWhenItIsClosed) {
  EventQueue queue(10'000);
  EXPECT_FALSE(queue.TakeWithin(milliseconds(1)));
  EXPECT_TRUE(queue.Put({.event = MakeRecorded(0)}));
  queue.Close();
  EXPECT_FALSE(queue.IsFinished());
  EXPECT_TRUE(queue.TakeWithin(std::chrono::hours(1)));
  EXPECT_TRUE(queue.IsFinished());
  EXPECT_FALSE(queue.TakeWithin(std::chrono::hours(1)));
}

}  // namespace

}  // namespace sprout::record
