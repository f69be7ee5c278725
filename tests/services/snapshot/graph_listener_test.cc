#include "services/snapshot/graph_listener.h"

#include <gtest/gtest.h>

#include <future>

#include "common/messages/codec.h"
#include "tests/common/app/captured_log.h"
#include "tests/common/bus/fake_tcpq_server.h"

namespace sprout::snapshot {
namespace {

// Listens to a server of its own, which hands over in order what is sent.
class GraphListenerTest : public ::testing::Test {
 protected:
  GraphListenerTest() {
    context_.lcm_url = server_.url();
    auto started =
        std::async(std::launch::async, [this] { listener_.emplace(context_, monitor_); });
    EXPECT_TRUE(server_.Accept());
    started.get();
  }

  void SendStatus(const std::string& stage, int64_t seq) {
    StageStatus status;
    status.stage = stage;
    status.newest_frame = {.utime = seq, .seq = seq, .rig_id = "rig"};
    const auto bytes = EncodeStatus(status);
    server_.Send("SPROUT_STATUS", {bytes.begin(), bytes.end()});
  }

  std::map<std::string, StageStatus> StatusesOf(int64_t seq) {
    const auto soon = StageMonitor::Clock::now() + std::chrono::seconds(20);
    return listener_->WaitForStatuses(seq, soon, {});
  }

  CapturedLog log_;
  FakeTcpqServer server_;
  ServiceContext context_;
  StageMonitor monitor_{"snapshot", ""};
  std::optional<GraphListener> listener_;
};

TEST_F(GraphListenerTest, KeepsTheNewestStatusOfEachStage) {
  for (const int64_t seq : {1, 2}) {
    for (const char* stage : {"refine", "grow"}) SendStatus(stage, seq);
  }
  const auto statuses = StatusesOf(2);
  EXPECT_EQ(statuses.size(), 2U);
  EXPECT_EQ(statuses.at("refine").newest_frame.seq, 2);
}

TEST_F(GraphListenerTest, KeepsNoMoreThan32StagesAndCountsTheOthersAsBad) {
  SendStatus("grow", 1);
  for (int i = 0; i < 1000; ++i) SendStatus("invented" + std::to_string(i), 2);
  SendStatus("grow", 2);  // now all that are kept have frame 2
  const auto statuses = StatusesOf(2);
  EXPECT_EQ(statuses.size(), 32U);
  EXPECT_TRUE(statuses.contains("grow"));
  EXPECT_EQ(monitor_.Snapshot().bad_messages, 1001 - 32);
}

}  // namespace
}  // namespace sprout::snapshot
