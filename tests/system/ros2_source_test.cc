// capture with ROS 2 as its cameras.
#include <gmock/gmock.h>

#include <csignal>
#include <map>
#include <mutex>
#include <thread>

#include "common/messages/codec.h"
#include "tests/common/picture/temporary_directory.h"
#include "tests/system/graph.h"
#include "tests/system/ros2_host.h"
#include "tests/system/run_program.h"

namespace sprout {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
using testing::Not;

std::vector<std::string> Send(const std::string& rig, int seconds) {
  return {"send", rig, "1920", "1080", "10", std::to_string(seconds)};
}

std::vector<std::string> Source() {
  return {"--source", "ros2:left=/cam/left/image_rect&right=/cam/right/image_rect"};
}

TEST(Ros2System, TakesPairsOfAnotherHost) {
  const OtherHost host;
  REQUIRE_HOST(host);
  Graph graph;
  Process& capture = graph.StartOnly("capture", Source());
  std::this_thread::sleep_for(1s);
  const auto first = host.Run(Send("/cam", Seconds()));
  EXPECT_EQ(End(*first), 0);
  // Gone and back.
  const auto second = host.Run(Send("/cam", Seconds()));
  EXPECT_EQ(End(*second), 0);
  std::this_thread::sleep_for(1500ms);
  const int sent = 2 * 10 * Seconds();
  const StageStatus status = graph.statuses["capture"];
  std::cout << "sent " << sent << " pairs, captured " << status.frames_out << ", failed "
            << status.frames_failed << "\n";
  // Images from before the end of discovery do not count.
  EXPECT_GE(status.frames_out + status.frames_failed, sent - 30) << capture.Output();
  EXPECT_LE(status.frames_failed, sent / 20) << capture.Output();
  EXPECT_THAT(capture.Output(), Not(HasSubstr("publishers on"))) << "one, then another one";
}

TEST(Ros2System, NamesTheTopicsBesideOneThatIsMistyped) {
  const Host host;
  Graph graph;
  Process& capture = graph.StartOnly(
      "capture", {"--source", "ros2:left=/cam/lft/image_rect&right=/cam/right/image_rect"});
  const auto camera = host.Run(Send("/cam", 12));
  EXPECT_TRUE(Says(capture,
                   "no message on /cam/lft/camera_info for 5 s; no publisher in domain 0; topics "
                   "of sensor_msgs/msg/CameraInfo there: /cam/left/camera_info "
                   "/cam/right/camera_info"))
      << capture.Output();
  EXPECT_TRUE(graph.WaitUntil([](Graph& g) {
    return g.statuses["capture"].last_error.starts_with("no message on /cam/lft/camera_info");
  })) << "it waits for its calibration, and has no status";
  camera->Signal(SIGKILL);
  capture.Signal(SIGKILL);
}

TEST(Ros2System, SaysWhatIsWrongOnATopic) {
  const OtherHost host;
  REQUIRE_HOST(host);
  Graph graph;
  Process& capture = graph.StartOnly("capture", Source());
  const auto text = host.Run({"send_text", "/cam/left/image_rect", "9"});
  const auto one = host.Run(Send("/cam", 9));
  const auto two = host.Run(Send("/cam", 9));
  EXPECT_TRUE(Says(capture, "2 publishers on /cam/left/image_rect; allowed is one"))
      << capture.Output();
  one->Signal(SIGKILL);
  two->Signal(SIGKILL);
  const auto only_text = host.Run({"send_text", "/cam/left/image_rect", "20"});
  EXPECT_TRUE(Says(capture, "no message on /cam/left/image_rect for")) << capture.Output();
}

TEST(Ros2System, TakesAScanOfAnotherHost) {
  const OtherHost host;
  REQUIRE_HOST(host);
  Graph graph("", kDefaultLcmUrl, {ChannelOf(Part::kTof)});
  std::vector<std::string> source = Source();
  source.back() += "&points=/cam/points";
  Process& capture = graph.StartOnly("capture", source);
  const auto scanner = host.Run(Send("/cam", Seconds() + 2));
  EXPECT_TRUE(graph.WaitUntil([](Graph& g) { return g.parts.size() >= 10; })) << capture.Output();
  EXPECT_EQ(End(*scanner), 0);
  std::vector<cv::Mat1f> scans;
  size_t frames = 0;
  graph.Look([&](Graph& g) {
    frames = g.parts.size();
    for (const auto& [key, part] : g.parts) {
      // A pair goes on without its scan when that comes late.
      const cv::Mat1f& depth_m = std::get<TofImage>(part).depth_m;
      if (!depth_m.empty()) scans.push_back(depth_m);
    }
  });
  EXPECT_GE(scans.size(), frames / 2);
  for (const cv::Mat1f& depth_m : scans) {
    ASSERT_EQ(depth_m.size(), cv::Size(1920, 1080));
    EXPECT_EQ(cv::countNonZero(depth_m > 0), 19 * 10);
    for (int v = 0; v < 1000; v += 100) EXPECT_FLOAT_EQ(depth_m(v, 1800), 2) << v;
  }
}

// Bytes of every disparity map of a graph, by frame.
class DisparityListener {
 public:
  explicit DisparityListener(const std::string& prefix)
      : receiver_(kDefaultLcmUrl, prefix, {ChannelOf(Part::kDisparity)},
                  [this](std::string_view, std::span<const uint8_t> bytes) {
                    const std::lock_guard lock(mutex_);
                    const Result<FrameId> id = DecodeFrameId(bytes);
                    if (id) heard_[id->seq].assign(bytes.begin(), bytes.end());
                  }) {}

  std::map<int64_t, std::vector<uint8_t>> heard() {
    const std::lock_guard lock(mutex_);
    return heard_;
  }

 private:
  std::mutex mutex_;
  std::map<int64_t, std::vector<uint8_t>> heard_;
  Receiver receiver_;  // last: stops before the rest is destroyed
};

std::map<int64_t, std::vector<uint8_t>> DisparitiesOf(const std::string& source,
                                                      const std::string& prefix) {
  Graph graph(prefix);
  DisparityListener listener(prefix);
  graph.StartChain();
  graph.Start("capture",
              {"--source", source, "--lockstep", "1", "--wait-for", "refine,prior,grow"});
  EXPECT_TRUE(graph.WaitUntil([](Graph& g) {
    return g.parts.contains({Part::kDisparity, 4});
  })) << graph.process("capture").Output();
  std::this_thread::sleep_for(100ms);
  return listener.heard();
}

TEST(Ros2System, AnExportGivesTheDisparitiesOfItsLog) {
  const TemporaryDirectory folder;
  OutputOf({"sprout-log", "export", "--mcap", folder / "out.mcap", kSampleLog});
  const auto of_log = DisparitiesOf("log:" + kSampleLog.string(), "LOG_");
  const auto of_export = DisparitiesOf("mcap:" + std::string(folder / "out.mcap") +
                                           "?left=/sprout/left/image_rect&right=/sprout/right/"
                                           "image_rect&depth=/sprout/tof/image_raw",
                                       "MCAP_");
  EXPECT_EQ(of_log.size(), 5U);
  EXPECT_EQ(of_export, of_log);
}

}  // namespace
}  // namespace sprout
