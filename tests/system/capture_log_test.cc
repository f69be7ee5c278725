#include <gmock/gmock.h>

#include "common/bus/channels.h"
#include "common/bus/receiver.h"
#include "tests/system/graph.h"
#include "tests/system/run_program.h"

namespace sprout {
namespace {

constexpr int64_t kLastSeq = 4;  // of the sample log

// Bytes of what capture sends, as they come.
class RawListener {
 public:
  explicit RawListener(const std::string& prefix)
      : receiver_(kDefaultLcmUrl, prefix,
                  {ChannelOf(Part::kLeft), ChannelOf(Part::kRight), ChannelOf(Part::kTof),
                   ChannelOf(Part::kRig)},
                  [this](std::string_view channel, std::span<const uint8_t> bytes) {
                    const std::lock_guard lock(mutex_);
                    heard_[std::string(channel)].emplace_back(bytes.begin(), bytes.end());
                  }) {}

  ChannelBytes heard() {
    const std::lock_guard lock(mutex_);
    return heard_;
  }

 private:
  std::mutex mutex_;
  ChannelBytes heard_;
  Receiver receiver_;  // last: stops before the rest is destroyed
};

bool HasLastDisparity(Graph& graph) { return graph.parts.contains({Part::kDisparity, kLastSeq}); }

// Everything as recorded; the calibration is sent more often, but never another one.
void ExpectAsRecorded(const ChannelBytes& heard) {
  const ChannelBytes recorded = ReadChannels(kSampleLog);
  for (const Part part : {Part::kLeft, Part::kRight, Part::kTof}) {
    const std::string channel(ChannelOf(part));
    ASSERT_TRUE(heard.contains(channel)) << channel;
    EXPECT_EQ(heard.at(channel), recorded.at(channel)) << channel;
  }
  const std::string channel(ChannelOf(Part::kRig));
  ASSERT_TRUE(heard.contains(channel));
  for (const auto& bytes : heard.at(channel)) {
    EXPECT_THAT(recorded.at(channel), testing::Contains(bytes));
  }
}

TEST(CaptureLogSystem, LockstepSendsTheWholeLogAsRecordedAndNoFrameIsLost) {
  // Sent with a prefix that the log does not have.
  Graph graph("AGAIN_");
  RawListener listener("AGAIN_");
  graph.StartChain();
  graph.Capture({"--source", "log:" + kSampleLog.string()});
  ASSERT_TRUE(graph.WaitUntil(HasLastDisparity));
  ExpectAsRecorded(listener.heard());
  graph.Look([](Graph& g) {
    for (int64_t seq = 0; seq <= kLastSeq; ++seq) {
      EXPECT_TRUE(g.parts.contains({Part::kDisparity, seq})) << seq;
    }
  });
}

TEST(CaptureLogSystem, KeepsTheRecordedPaceUnlessARateIsGiven) {
  Graph graph;
  graph.StartChain();
  const auto seconds = [&](std::vector<std::string> flags) {
    flags.insert(flags.begin(), {"--source", "log:" + kSampleLog.string()});
    const auto start = std::chrono::steady_clock::now();
    Process& capture = graph.StartOnly("capture", flags);
    EXPECT_EQ(capture.Wait(), 0) << capture.Output();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  EXPECT_GE(seconds({}), 0.75) << "four intervals of 0.2 s";
  EXPECT_GE(seconds({"--rate", "2"}), 2.0) << "four intervals of 0.5 s";
  EXPECT_TRUE(graph.WaitUntil(HasLastDisparity));
}

TEST(CaptureLogSystem, StockLogplayerFeedsTheGraph) {
  Graph graph;
  RawListener listener("");
  graph.StartChain();
  const std::string said = OutputOf({"lcm-logplayer", std::string("--lcm-url=") + kDefaultLcmUrl,
                                     "-e", "SPROUT_(LEFT|RIGHT|TOF|RIG)", kSampleLog});
  EXPECT_TRUE(graph.WaitUntil(HasLastDisparity)) << said;
  ExpectAsRecorded(listener.heard());
}

}  // namespace
}  // namespace sprout
