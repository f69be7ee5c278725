#include "common/app/live.h"

#include <gmock/gmock.h>
#include <unistd.h>

#include <csignal>
#include <optional>
#include <thread>

#include "common/core/digest.h"
#include "common/messages/codec.h"
#include "tests/common/app/captured_log.h"
#include "tests/common/bus/fake_tcpq_server.h"

namespace sprout {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

// LEFT → SEEDS, none, of a range sensor that is off.
class SeedlessAdapter : public StageAdapter {
 public:
  PartSet Inputs() const override { return {Part::kLeft}; }
  StageResult Process(const Frame&) override {
    return {.outputs = {{Part::kSeeds, SeedSet{}}}, .degenerate = "", .finding = "off by +10 mm"};
  }
};

class PairAdapter : public SeedlessAdapter {
 public:
  PartSet Inputs() const override { return {Part::kLeft, Part::kRight}; }
};

// A stage on a server of its own, with a connection each for its answers, its frames and its
// status, in this order.
class LiveTest : public ::testing::Test {
 protected:
  // As in every service: a server that hangs up is a failed publish, not a signal.
  LiveTest() : before_(std::signal(SIGPIPE, SIG_IGN)) {}
  ~LiveTest() override {
    stop_.request_stop();
    if (stage_.joinable()) stage_.join();
    std::signal(SIGPIPE, before_);
  }

  void ConnectForAnswers() {
    stage_ = std::jthread([this] { RunLive(context_, adapter_); });
    ASSERT_TRUE(server_.Accept());
  }

  void ConnectForFramesAndSendOne() {
    ASSERT_TRUE(server_.Accept());
    EXPECT_EQ(server_.Receive().channel, "SPROUT_LEFT");  // the subscription
    SendImage(3, Part::kLeft);
  }

  void SendImage(int64_t seq, Part part) {
    const auto bytes = EncodePart({.utime = seq, .seq = seq, .rig_id = "rig"}, part,
                                  cv::Mat(2, 3, CV_8UC1, cv::Scalar(0)), DisparityEncoding());
    server_.Send(std::string(ChannelOf(part)), {bytes.begin(), bytes.end()});
  }

  // The first status after the frame came in and something became of it, or the last one.
  StageStatus ConnectForStatus() {
    StageStatus status;
    if (!server_.Accept()) return status;
    while (status.frames_out + status.frames_failed == 0 &&
           status.state != StageStatus::State::kStopped) {
      const auto [type, channel, bytes] = server_.Receive();
      if (type == 0) break;
      if (channel != "SPROUT_STATUS") continue;
      const auto decoded =
          DecodeStatus({reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()});
      if (!decoded) break;
      status = *decoded;
    }
    return status;
  }

  CapturedLog log_;
  void (*before_)(int);
  FakeTcpqServer server_;
  std::stop_source stop_;
  ServiceContext context_{.stage = "seedless",
                          .config = LoadConfig({}),
                          .lcm_url = server_.url(),
                          .prefix = "",
                          .replay = {},
                          .stop = stop_.get_token()};
  SeedlessAdapter adapter_;
  std::jthread stage_;
};

TEST_F(LiveTest, CountsAnAnswerThatWasPublishedAsOut) {
  ConnectForAnswers();
  ConnectForFramesAndSendOne();
  const StageStatus status = ConnectForStatus();
  EXPECT_EQ(status.frames_in, 1);
  EXPECT_EQ(status.frames_out, 1);
  EXPECT_EQ(status.frames_failed, 0);
  EXPECT_EQ(status.last_error, "off by +10 mm");
}

TEST_F(LiveTest, CountsAnAnswerThatCouldNotBePublishedAsFailed) {
  ConnectForAnswers();
  server_.Disconnect();
  ConnectForFramesAndSendOne();
  const StageStatus status = ConnectForStatus();
  EXPECT_EQ(status.frames_in, 1);
  EXPECT_EQ(status.frames_out, 0);
  EXPECT_EQ(status.frames_failed, 1);
  EXPECT_THAT(status.last_error, HasSubstr("SPROUT_SEEDS: could not be published ("));
}

TEST_F(LiveTest, CountsWhatWaitsWhenItStops) {
  PairAdapter adapter;
  stage_ = std::jthread([&] { RunLive(context_, adapter); });
  ASSERT_TRUE(server_.Accept());
  ASSERT_TRUE(server_.Accept());
  EXPECT_EQ(server_.Receive().channel, "SPROUT_LEFT");
  SendImage(1, Part::kLeft);
  SendImage(1, Part::kRight);
  SendImage(2, Part::kLeft);
  server_.Send("SPROUT_RIGHT", "the last message");
  while (log_.Lines().empty()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  stop_.request_stop();
  const StageStatus status = ConnectForStatus();
  stage_.join();
  EXPECT_EQ(status.frames_in, 1);
  EXPECT_EQ(status.frames_skipped, 1);
  EXPECT_EQ(status.frames_incomplete, 1);
  EXPECT_THAT(log_.Lines(), Contains(HasSubstr("1 frames in, 0 out, 1 skipped, 1 incomplete")));
}

TEST_F(LiveTest, SaysWhatItIsAndLogsItsCountsAtTheEnd) {
  ConnectForAnswers();
  ConnectForFramesAndSendOne();
  ASSERT_TRUE(server_.Accept());
  std::optional<ProcessInfo> info;
  int64_t frames_out = 0;
  while (!info || frames_out == 0) {
    const auto [type, channel, data] = server_.Receive();
    ASSERT_NE(type, 0) << "the stage is gone";
    const std::span bytes(reinterpret_cast<const uint8_t*>(data.data()), data.size());
    if (channel == "SPROUT_PROCESS") info = DecodeProcessInfo(bytes).value();
    if (channel == "SPROUT_STATUS") frames_out = DecodeStatus(bytes)->frames_out;
  }
  EXPECT_EQ(info->stage, "seedless");
  EXPECT_EQ(info->pid, getpid());
  EXPECT_EQ(info->config_text, ConfigText(context_.config));
  EXPECT_EQ(info->config_digest, Digest(info->config_text));
  stop_.request_stop();
  stage_.join();
  EXPECT_THAT(log_.Lines(), Contains(HasSubstr("1 frames in, 1 out")));
}

}  // namespace
}  // namespace sprout
