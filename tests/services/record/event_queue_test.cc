#include "services/record/event_queue.h"

#include <gtest/gtest.h>

#include "tests/services/record/make_event.h"

namespace sprout::record {
namespace {

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
