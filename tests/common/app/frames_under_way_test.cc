#include "common/app/frames_under_way.h"

#include <gtest/gtest.h>

#include <thread>

namespace sprout {
namespace {

using std::chrono::milliseconds;

FrameId Number(int64_t seq) { return {.utime = 1000 * seq, .seq = seq, .rig_id = "rig"}; }

class FramesUnderWayTest : public ::testing::Test {
 protected:
  // A frame on which each stage works so long, in a chain that is empty otherwise.
  void Finish(int64_t seq, milliseconds first, milliseconds second, milliseconds last) {
    now_ += first;
    frames_.Sent(Number(seq), first);
    now_ += second;
    if (second > milliseconds(0)) frames_.Passed(Number(seq));
    now_ += last;
    frames_.Answered(Number(seq));
  }
  void FinishSome(milliseconds first, milliseconds second, milliseconds last) {
    for (size_t i = 0; i < FramesUnderWay::kRemembered; ++i) {
      Finish(static_cast<int64_t>(1000 + i), first, second, last);
    }
  }
  bool HasRoom() { return frames_.WaitForRoom(milliseconds(0), {}); }
  void Send(int64_t seq) { frames_.Sent(Number(seq), milliseconds(10)); }

  FramesUnderWay::Clock::time_point now_{};
  FramesUnderWay frames_{[this] { return now_; }};
};

TEST_F(FramesUnderWayTest, AnyNumberIsUnderWayUntilOneIsAnswered) {
  for (int seq = 0; seq < 1000; ++seq) {
    EXPECT_TRUE(HasRoom());
    Send(seq);
    frames_.Passed(Number(seq));
    now_ += milliseconds(100);
  }
  EXPECT_EQ(frames_.Most(), std::nullopt);
}

TEST_F(FramesUnderWayTest, AsManyAsTheSlowestStageNeeds) {
  FinishSome(milliseconds(20), milliseconds(20), milliseconds(50));
  EXPECT_EQ(frames_.Most(), 2);
  FinishSome(milliseconds(20), milliseconds(50), milliseconds(20));
  EXPECT_EQ(frames_.Most(), 2);
  FinishSome(milliseconds(50), milliseconds(20), milliseconds(20));
  EXPECT_EQ(frames_.Most(), 2);
  FinishSome(milliseconds(40), milliseconds(20), milliseconds(50));
  EXPECT_EQ(frames_.Most(), 3);
  FinishSome(milliseconds(30), milliseconds(30), milliseconds(30));
  EXPECT_EQ(frames_.Most(), 3);
  FinishSome(milliseconds(30), milliseconds(0), milliseconds(30));  // without a second stage
  EXPECT_EQ(frames_.Most(), 2);
}

TEST_F(FramesUnderWayTest, WaitingForAStageIsNoWork) {
  // Sent every 50 ms, 10 ms in the second stage, 50 in the last one, two frames behind.
  FinishSome(milliseconds(10), milliseconds(10), milliseconds(50));
  for (int seq = 0; seq < 20; ++seq) {
    Send(seq);
    now_ += milliseconds(10);
    frames_.Passed(Number(seq));
    now_ += milliseconds(40);
    if (seq >= 2) frames_.Answered(Number(seq - 2));
  }
  EXPECT_EQ(frames_.Most(), 2);
}

TEST_F(FramesUnderWayTest, OneOfThemIsTheOneThatBegins) {
  FinishSome(milliseconds(20), milliseconds(20), milliseconds(50));  // two
  Send(1);
  EXPECT_TRUE(HasRoom());
  Send(2);
  EXPECT_FALSE(HasRoom());
  frames_.Passed(Number(1));
  EXPECT_FALSE(HasRoom());
  frames_.Answered(Number(1));
  EXPECT_TRUE(HasRoom());
  FinishSome(milliseconds(30), milliseconds(30), milliseconds(30));  // three
  for (int seq = 3; seq < 6; ++seq) {
    EXPECT_TRUE(HasRoom());
    Send(seq);
  }
  EXPECT_FALSE(HasRoom());
}

TEST_F(FramesUnderWayTest, AnAnswerAlsoEndsTheFramesBefore) {
  FinishSome(milliseconds(30), milliseconds(30), milliseconds(30));
  for (int seq = 1; seq < 4; ++seq) Send(seq);
  frames_.Answered(Number(2));  // the first one was lost
  Send(4);
  EXPECT_TRUE(HasRoom());
}

TEST_F(FramesUnderWayTest, AnswersToUnknownFramesCountForNothing) {
  frames_.Answered(Number(7));
  EXPECT_EQ(frames_.Most(), std::nullopt);
  FinishSome(milliseconds(30), milliseconds(30), milliseconds(30));
  for (int seq = 1; seq < 4; ++seq) Send(seq);
  frames_.Passed(Number(7));
  frames_.Answered(Number(7));
  EXPECT_FALSE(HasRoom());
}

TEST_F(FramesUnderWayTest, AStageThatIsGoneHoldsNothingBackForLong) {
  FinishSome(milliseconds(30), milliseconds(30), milliseconds(20));
  for (int seq = 1; seq < 4; ++seq) Send(seq);
  now_ += milliseconds(200);
  EXPECT_FALSE(HasRoom());
  now_ += milliseconds(1);  // four times 50
  for (int seq = 4; seq < 100; ++seq) {
    EXPECT_TRUE(HasRoom()) << seq;
    Send(seq);
    now_ += milliseconds(10);
  }
}

TEST_F(FramesUnderWayTest, WhatWasSentMeanwhileIsUnderWayWhenTheStageIsBack) {
  for (int seq = 0; seq < 4; ++seq) Send(seq);
  now_ += milliseconds(10);
  frames_.Answered(Number(0));
  EXPECT_FALSE(HasRoom());
}

TEST_F(FramesUnderWayTest, TheSlowestOfTheNewestEightSaysHowLongToWait) {
  Finish(0, milliseconds(10), milliseconds(100), milliseconds(400));
  for (int seq = 1; seq < 8; ++seq) Finish(seq, milliseconds(5), milliseconds(5), milliseconds(5));
  for (int seq = 8; seq < 12; ++seq) Send(seq);
  now_ += milliseconds(2000);
  EXPECT_FALSE(HasRoom());
  frames_.Answered(Number(11));
  FinishSome(milliseconds(5), milliseconds(5), milliseconds(5));
  for (int seq = 20; seq < 24; ++seq) Send(seq);
  now_ += milliseconds(41);
  EXPECT_TRUE(HasRoom());
}

TEST_F(FramesUnderWayTest, WaitingEndsWithTheAnswer) {
  FramesUnderWay frames;
  const auto send = [&](int64_t seq) { frames.Sent(Number(seq), std::chrono::seconds(1)); };
  send(0);
  std::this_thread::sleep_for(std::chrono::seconds(1));
  frames.Answered(Number(0));
  send(1);
  send(2);
  EXPECT_FALSE(frames.WaitForRoom(milliseconds(1), {}));
  const std::jthread last([&] { frames.Answered(Number(2)); });
  EXPECT_TRUE(frames.WaitForRoom(std::chrono::seconds(3), {}));
}

TEST_F(FramesUnderWayTest, WaitingEndsWhenTheStageIsStopped) {
  FinishSome(milliseconds(30), milliseconds(30), milliseconds(30));
  for (int seq = 1; seq < 4; ++seq) Send(seq);
  std::stop_source stop;
  stop.request_stop();
  EXPECT_FALSE(frames_.WaitForRoom(std::chrono::hours(1), stop.get_token()));
}

}  // namespace
}  // namespace sprout
