#include "services/capture/answer_tracker.h"

#include <gmock/gmock.h>

#include <future>
#include <limits>
#include <thread>

#include "common/messages/codec.h"
#include "tests/common/app/captured_log.h"
#include "tests/common/bus/fake_tcpq_server.h"

namespace sprout::capture {
namespace {

using testing::ElementsAre;

std::string Text(const std::vector<uint8_t>& bytes) { return {bytes.begin(), bytes.end()}; }

// The tracker is connected to a server of the test, which delivers messages in the order of
// sending.
class AnswersTest : public ::testing::Test {
 protected:
  void Start(const std::vector<std::string>& stages) {
    context_.lcm_url = server_.url();
    auto started = std::async(std::launch::async, [&] {
      answers_.emplace(context_, monitor_, stages, /*disparities=*/true);
    });
    ASSERT_TRUE(server_.Accept());
    for (int channel = 0; channel < 2; ++channel) server_.Receive();  // subscriptions
    started.get();
  }

  void SendDisparity(const FrameId& id) {
    server_.Send("SPROUT_DISPARITY",
                 Text(EncodePart(id, Part::kDisparity, DisparityImage(cv::Size(4, 3)))));
  }

  void SendStatus(const std::string& stage, StageStatus::State state = StageStatus::State::kReady) {
    StageStatus status;
    status.stage = stage;
    status.state = state;
    server_.Send("SPROUT_STATUS", Text(EncodeStatus(status)));
  }

  static AnswerTracker::Deadline Soon() {
    return StageMonitor::Clock::now() + std::chrono::seconds(20);
  }

  CapturedLog log_;
  FakeTcpqServer server_;
  ServiceContext context_;
  StageMonitor monitor_{"capture", ""};
  std::optional<AnswerTracker> answers_;
};

TEST_F(AnswersTest, TakesAnAnswerToAnotherCaptureForNone) {
  Start({});
  const FrameId frame{.utime = 1000, .seq = 7, .rig_id = "rig"};
  const FrameId next{.utime = 2000, .seq = 8, .rig_id = "rig"};
  answers_->Expect(frame);
  answers_->Expect(next);
  FrameId other_time = frame;
  ++other_time.utime;
  FrameId other_rig = frame;
  other_rig.rig_id = "another";
  for (const FrameId& id : {other_time, other_rig, next}) SendDisparity(id);
  answers_->WaitForRoom(1, Soon(), {});
  EXPECT_TRUE(answers_->IsAnswered(next));
  EXPECT_FALSE(answers_->IsAnswered(frame));
  SendDisparity(frame);
  answers_->WaitForRoom(0, Soon(), {});
  EXPECT_TRUE(answers_->IsAnswered(frame));
  EXPECT_EQ(monitor_.Snapshot().bad_messages, 0);
}

TEST_F(AnswersTest, TakesABadMessageForNoAnswer) {
  Start({});
  const FrameId frame{.utime = 1000, .seq = 7, .rig_id = "rig"};
  const FrameId next{.utime = 2000, .seq = 8, .rig_id = "rig"};
  answers_->Expect(frame);
  answers_->Expect(next);
  auto cut = EncodePart(frame, Part::kDisparity, DisparityImage(cv::Size(4, 3)));
  cut.pop_back();
  server_.Send("SPROUT_DISPARITY", Text(cut));
  SendDisparity(next);
  answers_->WaitForRoom(1, Soon(), {});
  EXPECT_FALSE(answers_->IsAnswered(frame));
  EXPECT_EQ(monitor_.Snapshot().bad_messages, 1);
}

TEST_F(AnswersTest, NamesTheStagesThatHaveNotReported) {
  Start({"refine", "grow"});
  for (const char* stage : {"refine", "somebody else"}) SendStatus(stage);
  EXPECT_THAT(answers_->WaitForStages(StageMonitor::Clock::now(), {}).size(), testing::Ge(1U));
  SendStatus("grow");
  EXPECT_THAT(answers_->WaitForStages(Soon(), {}), ElementsAre());
}

TEST_F(AnswersTest, TakesTheLastStatusOfAStageForNoPresence) {
  Start({"refine", "grow"});
  SendStatus("grow", StageStatus::State::kStopped);
  SendStatus("refine");
  const auto silent = [&] { return answers_->WaitForStages(StageMonitor::Clock::now(), {}); };
  while (silent().contains("refine")) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  EXPECT_THAT(silent(), ElementsAre("grow")) << "it was stopped";
  SendStatus("grow", StageStatus::State::kRunning);
  EXPECT_THAT(answers_->WaitForStages(Soon(), {}), ElementsAre());
}

using std::chrono::milliseconds;
using std::chrono::seconds;

FrameId At(int64_t utime) { return {.utime = utime, .seq = 0, .rig_id = ""}; }

class PaceTest : public ::testing::Test {
 protected:
  Pace::Clock::time_point start_ = Pace::Clock::now();
};

TEST_F(PaceTest, WaitsForTheRateBeforeTakingAndNotBeforeSending) {
  Pace pace = Pace::AtRate(10);
  pace.Start(start_);
  EXPECT_EQ(pace.DueBeforeTaking(), start_);
  for (int i = 1; i <= 7; ++i) {
    // Each frame is taken a little late, which does not add up.
    const auto now = pace.DueBeforeTaking() + milliseconds(10);
    pace.Take(now);
    EXPECT_LE(pace.DueBeforeSending(At(5'000'000), now), now);
    EXPECT_EQ(pace.DueBeforeTaking(), start_ + milliseconds(100 * i));
  }
}

TEST_F(PaceTest, DoesNotCatchUpInABurstAfterAStall) {
  Pace pace = Pace::AtRate(10);
  pace.Start(start_);
  pace.Take(start_);
  pace.Take(start_ + seconds(5));
  EXPECT_EQ(pace.DueBeforeTaking(), start_ + seconds(5) + milliseconds(100));

  Pace recorded = Pace::AsRecorded();
  recorded.Start(start_);
  recorded.DueBeforeSending(At(1'000'000), start_);
  EXPECT_EQ(recorded.DueBeforeSending(At(1'100'000), start_ + milliseconds(150)),
            start_ + milliseconds(100))
      << "a little late";
  const auto late = start_ + seconds(5);
  EXPECT_EQ(recorded.DueBeforeSending(At(1'200'000), late), late);
  EXPECT_EQ(recorded.DueBeforeSending(At(1'300'000), late), late + milliseconds(100));
}

TEST_F(PaceTest, NeverWaitsAtRateZero) {
  Pace pace = Pace::AtRate(0);
  pace.Start(start_);
  for (int i = 0; i < 1000; ++i) pace.Take(start_);
  EXPECT_LE(pace.DueBeforeTaking(), start_);
  EXPECT_LE(pace.DueBeforeSending(At(5'000'000), start_), start_);
}

TEST_F(PaceTest, WaitsForYearsAtTheLowestRates) {
  for (const double rate_hz : {1e-10, 1e-300, std::numeric_limits<double>::denorm_min()}) {
    Pace pace = Pace::AtRate(rate_hz);
    pace.Start(start_);
    pace.Take(start_);
    EXPECT_GT(pace.DueBeforeTaking(), start_ + std::chrono::hours(24 * 365)) << rate_hz;
  }
}

TEST_F(PaceTest, KeepsTheRecordedIntervals) {
  Pace pace = Pace::AsRecorded();
  pace.Start(start_);
  EXPECT_EQ(pace.DueBeforeSending(At(1'000'000), start_), start_);
  pace.Take(start_);
  EXPECT_LE(pace.DueBeforeTaking(), start_);
  EXPECT_EQ(pace.DueBeforeSending(At(1'100'000), start_), start_ + milliseconds(100));
  EXPECT_EQ(pace.DueBeforeSending(At(1'350'000), start_ + milliseconds(100)),
            start_ + milliseconds(350));
}

TEST_F(PaceTest, TakesAStepBackAsNoneAndALongPauseAsTenSeconds) {
  Pace pace = Pace::AsRecorded();
  pace.Start(start_);
  const auto due = [&](int64_t utime) { return pace.DueBeforeSending(At(utime), start_); };
  due(1'000'000);
  EXPECT_EQ(due(400'000), start_);
  EXPECT_EQ(due(500'000), start_ + milliseconds(100));
  EXPECT_EQ(due(std::numeric_limits<int64_t>::max()), start_ + milliseconds(100) + seconds(10));
  EXPECT_EQ(due(0), start_ + milliseconds(100) + seconds(10));
}

TEST_F(PaceTest, SaysWhenAFrameComesMoreThanAnIntervalLate) {
  Pace pace = Pace::AtRate(10);
  const Pace::Clock::time_point start{};
  pace.Start(start);
  EXPECT_FALSE(pace.IsLate(start + std::chrono::milliseconds(90)));
  EXPECT_TRUE(pace.IsLate(start + std::chrono::milliseconds(110)));
  pace.Take(start + std::chrono::milliseconds(110));
  EXPECT_FALSE(pace.IsLate(start + std::chrono::milliseconds(300)));
  EXPECT_FALSE(Pace::AtRate(0).IsLate(start + std::chrono::hours(1)));
  EXPECT_FALSE(Pace::AsRecorded().IsLate(start + std::chrono::hours(1)));
}

}  // namespace

}  // namespace sprout::capture
