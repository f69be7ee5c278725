#include "services/capture/answer_tracker.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <future>

#include "common/messages/codec.h"
#include "tests/common/app/captured_log.h"
#include "tests/common/bus/fake_tcpq_server.h"

namespace sprout::capture {
namespace {

using testing::ElementsAre;

std::string Text(const std::vector<uint8_t>& bytes) { return {bytes.begin(), bytes.end()}; }

// Listens to a server of its own, which hands over in order what is sent.
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
                 Text(EncodePart(id, Part::kDisparity, DisparityImage(cv::Size(4, 3)),
                                 DisparityEncoding::kRawInt16)));
  }

  void SendStatus(const std::string& stage) {
    StageStatus status;
    status.stage = stage;
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
  auto cut = EncodePart(frame, Part::kDisparity, DisparityImage(cv::Size(4, 3)),
                        DisparityEncoding::kRawInt16);
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

}  // namespace
}  // namespace sprout::capture
