// Sprout and nodes of ROS 2 on Fast DDS, ROS 2's default middleware, on one host, with the receive
// buffer that the kernel gives everybody.
#include <gmock/gmock.h>

#include <csignal>
#include <fstream>
#include <thread>

#include "tests/system/ros2_fast_peers.h"
#include "tests/system/ros2_feed.h"

namespace sprout {
namespace {

using testing::HasSubstr;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

const std::string kDepth = "/sprout/depth/image_rect";
const std::string kPoints = "/sprout/points";

std::unique_ptr<Process> Listener(const std::string& more = "") {
  std::vector<std::string> arguments = {"hear", "0", "1000", kDepth + "=image"};
  if (!more.empty()) arguments.push_back(more);
  return Peer(arguments);
}

// Sends until everybody has heard something.
void WarmUp(FeedGraph& feed, std::initializer_list<Process*> peers) {
  for (int i = 0; i < 20; ++i) {
    feed.Run(1);
    const bool all_hear = std::ranges::all_of(peers, [](Process* peer) {
      return peer->Output().find("first message of " + kDepth) != std::string::npos;
    });
    if (all_hear) return;
  }
  ADD_FAILURE() << "a peer hears nothing";
}

void GetEveryImage(cv::Size size, const std::string& qos = "reliable") {
  FedGraph graph;
  graph.Start("ros2");
  const auto peer = Peer({"hear", "0", "1000", kDepth + "=image", kPoints + "=points", qos});
  FeedGraph feed(graph, size);
  WarmUp(feed, {peer.get()});
  const StageStatus before = FinalStatus(graph);
  const Heard warm = HeardOf(peer->Output(), kDepth);
  const int sent = feed.Run(Seconds());
  const StageStatus status = FinalStatus(graph);
  peer->Signal(SIGTERM);
  ASSERT_EQ(End(*peer), 0);
  const long heard =
      HeardOf(peer->Output(), kDepth).messages + HeardOf(peer->Output(), kPoints).messages;
  std::cout << "sent " << sent << " frames, shown " << status.frames_out - before.frames_out
            << " messages, failed " << status.frames_failed << "; heard from the first second on:\n"
            << peer->Output();
  // Images from before the end of discovery do not count; the bus may lose frames, which are
  // counted.
  EXPECT_GE(heard + status.sequence_gaps, status.frames_out - 20) << warm.line;
  EXPECT_EQ(status.frames_failed, 0);
}

// A depth image has ten datagrams; a socket's buffer, three.
TEST(Ros2Fast, SubscribersGetEveryImage) { GetEveryImage({640, 480}); }

// 64 datagrams, for which both sides need the CPU at once.
TEST(Ros2FastLong, SubscribersGetEveryImageOf2Mp) { GetEveryImage(FeedGraph::kSize); }

// As the sensor data QoS of ROS 2. A socket has to hold an image then: see README.
bool SocketsHoldAnImage() {
  int bytes = 0;
  std::ifstream("/proc/sys/net/core/rmem_default") >> bytes;
  return bytes >= 8'000'000;
}
TEST(Ros2FastLong, BestEffortSubscribersGetEveryImage) {
  if (!SocketsHoldAnImage()) GTEST_SKIP() << "net.core.rmem_default is below 8 MB (scripts/setup)";
  GetEveryImage({640, 480}, "best_effort");
}
TEST(Ros2FastLong, BestEffortSubscribersGetEveryImageOf2Mp) {
  if (!SocketsHoldAnImage()) GTEST_SKIP() << "net.core.rmem_default is below 8 MB (scripts/setup)";
  GetEveryImage(FeedGraph::kSize, "best_effort");
}

void AreNotHeldUpBy(int signal, bool best_effort) {
  FedGraph graph;
  graph.Start("ros2");
  const auto healthy = Listener(best_effort ? "best_effort" : "");
  const auto other = Listener();
  FeedGraph feed(graph, {640, 480});
  WarmUp(feed, {healthy.get(), other.get()});
  other->Signal(signal);
  const int sent = feed.Run(Seconds());
  const StageStatus status = FinalStatus(graph);
  const Heard heard = EndOf(*healthy, kDepth);
  other->Signal(SIGKILL);
  std::cout << "sent " << sent << " frames beside it, failed " << status.frames_failed << "\n"
            << heard.line << "\n";
  EXPECT_EQ(status.frames_failed, 0);
  EXPECT_GE(heard.messages, best_effort ? 1 : sent);
  if (!best_effort) {
    EXPECT_LE(heard.longest_pause_s, 1);
  }
}

TEST(Ros2Fast, AKilledSubscriberHoldsUpNobody) { AreNotHeldUpBy(SIGKILL, /*best_effort=*/false); }
TEST(Ros2Fast, AStoppedSubscriberHoldsUpNobody) { AreNotHeldUpBy(SIGSTOP, /*best_effort=*/false); }

TEST(Ros2Fast, EndsAtOnceBesideADeadSubscriber) {
  FedGraph graph;
  Process& bridge = graph.Start("ros2");
  const auto peer = Listener();
  FeedGraph feed(graph, {640, 480});
  WarmUp(feed, {peer.get()});
  peer->Signal(SIGKILL);
  feed.Run(1);
  EXPECT_LT(TimeToEnd(bridge), 1s) << bridge.Output();
}

TEST(Ros2Fast, ToolsShowItAsANode) {
  FedGraph graph;
  graph.Start("ros2");
  const auto peer = Peer({"graph", "0", "3"});
  ASSERT_EQ(End(*peer), 0);
  const std::string seen = peer->Output();
  // All GIDs that the node names are those of endpoints.
  EXPECT_THAT(seen, HasSubstr("node /sprout readers 0 writers 17 known 17")) << seen;
  EXPECT_THAT(seen, HasSubstr("user_data 'enclave=/;'"));
  EXPECT_THAT(seen,
              HasSubstr("writer rt/sprout/points sensor_msgs::msg::dds_::PointCloud2_ reliable "
                        "volatile user_data 'typehash=RIHS01_9198cabf7da3796ae6fe19c4cb3bdd35"
                        "25492988c70522628af5daa124bae2b5;'"));
}

TEST(Ros2Fast, IsFoundOnLocalhostAlone) {
  setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST", 1);
  FedGraph graph;
  graph.Start("ros2");
  unsetenv("ROS_AUTOMATIC_DISCOVERY_RANGE");
  const auto peer = Peer({"graph", "0", "4", "localhost"});
  ASSERT_EQ(End(*peer), 0);
  EXPECT_THAT(peer->Output(), HasSubstr("node /sprout readers 0 writers 17 known 17"));
}

TEST(Ros2Fast, SaysWhichSubscriberCannotBeServed) {
  FedGraph graph;
  Process& bridge = graph.Start("ros2", {"--best-effort"});
  const auto peer = Listener();
  EXPECT_TRUE(SaysSoon(bridge,
                       "a subscriber of /sprout/depth/image_rect gets nothing: it asks for more "
                       "than is offered (RELIABILITY)"))
      << bridge.Output();
}

TEST(Ros2Fast, CompressesImagesAndOrdersPoints) {
  FedGraph graph;
  Process& bridge =
      graph.Start("ros2", {"--compressed", "--config", "ros2 { ordered_points: true }"});
  const std::string jpeg = "/sprout/left/image_rect/compressed";
  const std::string png = kDepth + "/compressedDepth";
  const auto peer = Peer({"hear", "0", "1000", kDepth + "=image", jpeg + "=compressed",
                          png + "=compressed", kPoints + "=points"});
  FeedGraph feed(graph, {640, 480});
  WarmUp(feed, {peer.get()});
  feed.Run(1);
  const Heard of_depth = EndOf(*peer, png);
  EXPECT_GE(of_depth.messages, 10) << bridge.Output();
  EXPECT_THAT(of_depth.line, HasSubstr("16UC1; compressedDepth png"));
  const Heard of_left = HeardOf(peer->Output(), jpeg);
  EXPECT_GE(of_left.messages, 10);
  EXPECT_THAT(of_left.line, HasSubstr("mono8; jpeg compressed"));
  // All points of the feed are at one place, which is no pixel.
  EXPECT_EQ(HeardOf(peer->Output(), kPoints).messages, 0);
  EXPECT_THAT(bridge.Output(), HasSubstr("an ordered cloud has every 4. one"));
}

// ---- capture ----

// Images from before capture knew the camera do not count: up to a second on a busy machine.
void CapturesAll(const std::string& size, const std::vector<std::string>& more) {
  FedGraph graph;
  Process& capture = graph.StartOnly("capture", Source());
  const auto camera = Peer(Camera(size, std::to_string(Seconds()), more));
  ASSERT_EQ(End(*camera), 0);
  const StageStatus status = StatusOf(graph);
  std::cout << camera->Output() << "captured " << status.frames_out << ", failed "
            << status.frames_failed << "\n";
  EXPECT_GE(status.frames_out, 10 * (Seconds() - 1)) << capture.Output();
  EXPECT_EQ(status.frames_failed, 0) << capture.Output();
  EXPECT_EQ(status.last_error, "") << capture.Output();
}

TEST(Ros2Fast, CapturesEveryPairOfAReliableCamera) { CapturesAll("1920x1080", {}); }
TEST(Ros2Fast, CapturesABestEffortCamera) { CapturesAll("320x240", {"best_effort"}); }
TEST(Ros2FastLong, CapturesEveryPairOfASmallReliableCamera) { CapturesAll("640x480", {}); }
TEST(Ros2FastLong, CapturesABestEffortCameraOfVga) { CapturesAll("640x480", {"best_effort"}); }
TEST(Ros2FastLong, CapturesABestEffortCameraOf2Mp) { CapturesAll("1920x1080", {"best_effort"}); }
TEST(Ros2Fast, CapturesACameraWhoseInfoIsLatched) { CapturesAll("320x240", {"info=latched"}); }

// Camera, capture, sprout-ros2, viewer.
TEST(Ros2Fast, ShowsTheImagesOfALiveCamera) {
  FedGraph graph;
  Process& capture = graph.StartOnly("capture", Source());
  Process& bridge = graph.Start("ros2");
  const std::string topic = "/sprout/left/image_rect";
  const auto viewer = Peer({"hear", "0", "1000", topic + "=image"});
  const auto camera = Peer(Camera("1920x1080", std::to_string(Seconds() + 2)));
  ASSERT_EQ(End(*camera), 0);
  const StageStatus status = StatusOf(graph);
  const Heard heard = EndOf(*viewer, topic);
  std::cout << "captured " << status.frames_out << ", failed " << status.frames_failed << "; "
            << heard.line << "\n";
  EXPECT_EQ(status.frames_failed, 0) << capture.Output();
  EXPECT_GE(heard.messages, 10 * Seconds()) << bridge.Output();
  EXPECT_LE(heard.longest_pause_s, 1);
}

TEST(Ros2Fast, AnEncodingThatCannotBeUsedIsSaidAndCountedAtOnce) {
  FedGraph graph;
  Process& capture = graph.StartOnly("capture", Source());
  const auto camera = Peer(Camera("320x240", "20", {"encoding=nonsense"}));
  EXPECT_TRUE(SaysSoon(capture, "/cam/left/image_rect: message dropped")) << capture.Output();
  EXPECT_TRUE(graph.WaitUntil([](Graph& g) { return g.statuses["capture"].bad_messages > 10; }));
  camera->Signal(SIGTERM);
}

TEST(Ros2Fast, FindsItsPublisherAmongManyOthers) {
  FedGraph graph;
  const auto others = Peer({"many", "0", "60", "400"});
  ASSERT_TRUE(SaysSoon(*others, "made"));
  Process& capture = graph.StartOnly("capture", Source("&left_info=/cam/right/image_rect"));
  const auto camera = Peer(Camera("320x240", "20", {"wait=0"}));
  EXPECT_TRUE(SaysSoon(capture,
                       "no message on /cam/right/image_rect for 5 s; 1 publishers, 1 of other "
                       "types such as sensor_msgs::msg::dds_::Image_"))
      << capture.Output();
  camera->Signal(SIGTERM);
  others->Signal(SIGTERM);
}

TEST(Ros2Fast, CaptureObeysRosDomainId) {
  setenv("ROS_DOMAIN_ID", "7", 1);
  FedGraph graph;
  Process& capture = graph.StartOnly("capture", Source());
  unsetenv("ROS_DOMAIN_ID");
  std::vector<std::string> of_seven = Camera("320x240", "2");
  of_seven[1] = "7";
  const auto camera = Peer(of_seven);
  ASSERT_EQ(End(*camera), 0);
  EXPECT_GE(StatusOf(graph).frames_out, 10) << capture.Output();
}

TEST(Ros2Fast, StampsThatGoBackAnHourStopNothing) {
  FedGraph graph;
  Process& capture = graph.StartOnly("capture", Source());
  const auto camera = Peer(Camera("320x240", "4", {"jump_at=20", "jump_s=-3600"}));
  ASSERT_EQ(End(*camera), 0);
  const StageStatus status = StatusOf(graph);
  EXPECT_GE(status.frames_out, 30) << capture.Output();
  EXPECT_EQ(status.frames_failed, 0);
  EXPECT_THAT(capture.Output(), HasSubstr("the cameras' clock was set back by 3599."));
}

TEST(Ros2Fast, ANewCameraInfoMakesANewRig) {
  Graph graph("", kDefaultLcmUrl, {kStatusChannel, ChannelOf(Part::kRig)});
  Process& capture = graph.StartOnly("capture", Source());
  const auto camera = Peer(Camera("320x240", "3", {"focal_at=15"}));
  ASSERT_EQ(End(*camera), 0);
  double last_focal = 0;
  int before = 0;
  graph.Look([&](Graph& g) {
    for (const auto& [key, part] : g.parts) {
      last_focal = std::get<Rig>(part).pair.focal_px;
      if (last_focal == 320) ++before;
    }
  });
  EXPECT_GT(before, 0);
  EXPECT_EQ(last_focal, 640) << capture.Output();
  EXPECT_GE(StatusOf(graph).frames_out, 20) << capture.Output();
}

long ResidentMegabytes(pid_t pid) {
  long pages = 0;
  std::ifstream statm("/proc/" + std::to_string(pid) + "/statm");
  statm >> pages >> pages;
  return pages * 4096 / 1'000'000;
}

TEST(Ros2Fast, HugeImagesTakeNoMemory) {
  FedGraph graph;
  Process& capture = graph.StartOnly("capture", Source());
  const auto camera = Peer(Camera("320x240", "60", {"huge=100000000"}));
  long most = 0;
  for (const auto end = Clock::now() + 8s; Clock::now() < end;) {
    most = std::max(most, ResidentMegabytes(capture.pid()));
    std::this_thread::sleep_for(50ms);
  }
  camera->Signal(SIGKILL);
  std::cout << "at most " << most << " MB\n";
  EXPECT_LT(most, 200) << capture.Output();
  EXPECT_GT(StatusOf(graph).bad_messages, 0) << capture.Output();
}

TEST(Ros2Fast, EndsAtOnceWhileItWaitsForACalibration) {
  Process capture({ProgramPath("sprout-capture"), "--source", Source()[1]});
  ASSERT_TRUE(SaysSoon(capture, "configuration"));
  std::this_thread::sleep_for(500ms);
  EXPECT_LT(TimeToEnd(capture), 1s) << capture.Output();
}

TEST(Ros2Fast, WithoutAPublisherItEndsAsTheReadmeSays) {
  const auto begin = Clock::now();
  Process capture({ProgramPath("sprout-capture"), "--source", Source()[1]});
  EXPECT_EQ(capture.Wait(30s), 2);
  EXPECT_LT(Clock::now() - begin, 27s);
  EXPECT_THAT(capture.Output(), HasSubstr("no message on /cam/left/camera_info; no publisher"));
}

TEST(Ros2Fast, MessagesThatAreNoneAreCountedNotPrinted) {
  FedGraph graph;
  Process& capture = graph.StartOnly("capture", Source());
  const auto camera = Peer(Camera("320x240", "4"));
  const auto strings = Peer({"strings", "0", "60", "500", "/cam/left/image_rect"});
  ASSERT_EQ(End(*camera), 0);
  strings->Signal(SIGTERM);
  const StageStatus status = StatusOf(graph);
  const std::string output = capture.Output();
  std::cout << status.bad_messages << " bad messages\n";
  EXPECT_GT(status.bad_messages, 100) << output;
  EXPECT_LT(std::ranges::count(output, '\n'), 40) << output;
  EXPECT_GE(status.frames_out, 30) << output;
}

}  // namespace
}  // namespace sprout
