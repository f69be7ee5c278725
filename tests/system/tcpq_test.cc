// The whole graph over LCM's own tcpq server, which is killed and started again.
#include <gmock/gmock.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>

#include "common/bus/lcm_url.h"
#include "tests/system/eventually.h"
#include "tests/system/graph.h"
#include "tests/system/graph_record.h"

namespace sprout {
namespace {

constexpr const char* kUrl = "tcpq://127.0.0.1:7700";

class TcpqSystem : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(LCM_JAR)) GTEST_SKIP() << "no tcpq server: no " << LCM_JAR;
    StartServer();
    record_ = std::make_unique<GraphRecord>(kUrl);
    graph_ = std::make_unique<Graph>("", kUrl);
    graph_->StartChain();
  }

  void StartServer() {
    server_ = std::make_unique<Process>(
        std::vector<std::string>{"java", "-cp", LCM_JAR, "lcm.lcm.TCPService", "7700"});
    EXPECT_TRUE(Eventually([] {
      try {
        OpenLcm(kUrl);
        return true;
      } catch (const BusError&) {
        return false;
      }
    })) << server_->Output();
  }

  void KillServer() {
    server_->Signal(SIGKILL);
    server_->Wait();
  }

  int64_t MapsSince(GraphRecord& record, size_t first) {
    int64_t maps = 0;
    for (size_t i = first; i < record.sent.size(); ++i) {
      maps += record.frames[record.sent[i]].at.contains(Part::kDisparity);
    }
    return maps;
  }

  // Waits for so many maps of frames that are sent from now on.
  void ExpectMaps(int64_t count) {
    std::optional<size_t> first;
    EXPECT_TRUE(record_->WaitUntil([&](GraphRecord& r) {
      if (!first) first = r.sent.size();
      return MapsSince(r, *first) >= count;
    }));
  }

  std::unique_ptr<Process> server_;
  std::unique_ptr<GraphRecord> record_;
  std::unique_ptr<Graph> graph_;
};

TEST_F(TcpqSystem, TheGraphGoesOnWhenTheServerIsBackAndCountsWhatWasLost) {
  Process& capture =
      graph_->StartOnly("capture", {"--source", "synthetic:160x120", "--rate", "10"});
  ExpectMaps(10);
  KillServer();
  ASSERT_TRUE(Says(capture, ": could not be published")) << capture.Output();
  StartServer();
  ExpectMaps(10);
  capture.Signal(SIGTERM);
  capture.Wait();
  EXPECT_THAT(capture.Output(), testing::ContainsRegex("[1-9][0-9]* could not be sent"))
      << "what was not sent is said";
  std::map<GraphRecord::Key, GraphRecord::Heard> frames;
  // The last frame that was sent comes through all stages, and each has accounted for all since its
  // first.
  EXPECT_TRUE(record_->WaitUntil([&](GraphRecord& r) {
    frames = r.frames;
    return std::all_of(std::begin(kChain), std::end(kChain), [&](const char* stage) {
      const StageStatus& status = r.statuses[graph_->process(stage).pid()];
      const int64_t last = frames.rbegin()->first.second;
      const int64_t first = frames.begin()->first.second;
      return status.newest_frame.seq == last && AccountedFor(status) == last - first + 1;
    });
  }));
  const Comparison comparison = CompareWithPipeline(frames, LoadConfig({"default"}));
  EXPECT_GE(comparison.maps, 20);
  EXPECT_EQ(comparison.wrong, 0) << comparison.first_wrong;
}

}  // namespace
}  // namespace sprout
