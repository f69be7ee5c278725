#include "common/bus/mailbox.h"

#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <thread>

namespace sprout {
namespace {

TEST(Mailbox, KeepsTheNewestAndSaysThatOneWasReplaced) {
  Mailbox<int> mailbox;
  EXPECT_FALSE(mailbox.Put(1));
  EXPECT_TRUE(mailbox.Put(2));
  EXPECT_TRUE(mailbox.Put(3));
  EXPECT_EQ(mailbox.Take(std::stop_token()), 3);
  EXPECT_FALSE(mailbox.Put(4)) << "the mailbox was empty again";
}

TEST(Mailbox, GivesNothingWhenNoneCameInTime) {
  Mailbox<int> mailbox;
  EXPECT_EQ(mailbox.TakeWithin(std::chrono::milliseconds(1), std::stop_token()), std::nullopt);
  mailbox.Put(1);
  EXPECT_EQ(mailbox.TakeWithin(std::chrono::milliseconds(0), std::stop_token()), 1);
}

TEST(Mailbox, TakesMoveOnlyValues) {
  Mailbox<std::unique_ptr<int>> mailbox;
  mailbox.Put(std::make_unique<int>(5));
  const std::optional<std::unique_ptr<int>> taken = mailbox.Take(std::stop_token());
  ASSERT_TRUE(taken);
  EXPECT_EQ(**taken, 5);
}

TEST(Mailbox, GivesNothingAfterAStopEvenWhenItIsFull) {
  // A stage that is slower than its input always finds a frame: it could never be stopped.
  Mailbox<int> mailbox;
  std::stop_source source;
  mailbox.Put(1);
  source.request_stop();
  EXPECT_EQ(mailbox.Take(source.get_token()), std::nullopt);
}

TEST(Mailbox, WakesAWaitingTakerOnStop) {
  Mailbox<int> mailbox;
  std::stop_source source;
  std::atomic<bool> returned = false;
  std::jthread taker([&] {
    EXPECT_EQ(mailbox.Take(source.get_token()), std::nullopt);
    returned = true;
  });
  source.request_stop();
  taker.join();
  EXPECT_TRUE(returned);
}

TEST(Mailbox, HandsOverBetweenThreadsInOrderAndLosesNothingUnsaid) {
  constexpr int kCount = 20000;
  Mailbox<int> mailbox;
  int replaced = 0;
  std::jthread sender([&] {
    for (int i = 1; i <= kCount; ++i) replaced += mailbox.Put(i) ? 1 : 0;
  });
  int taken = 0;
  for (int last = 0; last < kCount; ++taken) {
    const std::optional<int> value = mailbox.Take(std::stop_token());
    ASSERT_TRUE(value);
    ASSERT_GT(*value, last);
    last = *value;
  }
  sender.join();
  EXPECT_EQ(taken + replaced, kCount);
}

}  // namespace
}  // namespace sprout
