// sprout-ros2 between two hosts (network namespaces joined by a cable).
#include <gmock/gmock.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <thread>

#include "tests/system/ros2_feed.h"
#include "tests/system/ros2_host.h"
#include "tests/system/run_program.h"

namespace sprout {
namespace {

using testing::HasSubstr;
using namespace std::chrono_literals;

// "TOPIC N messages ..." of what the peer heard.
long Heard(const std::string& output, const std::string& topic) {
  std::istringstream lines(output);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string name;
    long count = 0;
    if (words >> name >> count && name == topic) return count;
  }
  return -1;
}

struct CpuTime {
  double user_ms = 0;
  double system_ms = 0;

  CpuTime operator-(const CpuTime& before) const {
    return {user_ms - before.user_ms, system_ms - before.system_ms};
  }
};

CpuTime CpuTimeOf(pid_t pid) {
  std::ifstream stat("/proc/" + std::to_string(pid) + "/stat");
  std::string word;
  for (int i = 0; i < 13; ++i) stat >> word;
  double user = 0;
  double system = 0;
  stat >> user >> system;
  const double tick_ms = 1000.0 / static_cast<double>(sysconf(_SC_CLK_TCK));
  return {user * tick_ms, system * tick_ms};
}

const std::string kUntilTold = "1000";

std::vector<std::string> Hear(const std::string& seconds, const std::string& sleep, bool reliable) {
  return {"hear",
          seconds,
          sleep,
          reliable ? "1" : "0",
          "/sprout/depth/image_rect=image",
          "/sprout/points=points"};
}

void ShowDepthAndPointsTo(const Host& host) {
  FedGraph graph;
  const Process& bridge = graph.Start("ros2", {"--domain", "0"});
  FeedGraph feed(graph);
  feed.Run(1);
  // Nobody listens: nothing is converted.
  EXPECT_FALSE(graph.WaitUntil([](Graph& g) { return g.statuses.at("ros2").frames_in > 0; }, 2s));
  const auto peer = host.Run(Hear(kUntilTold, "0", /*reliable=*/false));
  std::this_thread::sleep_for(2s);  // discovery
  const CpuTime before = CpuTimeOf(bridge.pid());
  const int sent = feed.Run(Seconds());
  const CpuTime cpu = CpuTimeOf(bridge.pid()) - before;
  std::this_thread::sleep_for(1s);
  peer->Signal(SIGTERM);
  EXPECT_EQ(End(*peer), 0);
  const std::string output = peer->Output();
  const long depths = Heard(output, "/sprout/depth/image_rect");
  const long points = Heard(output, "/sprout/points");
  const StageStatus status = FinalStatus(graph);
  std::cout << "sent " << sent << " frames, shown " << status.frames_out << " messages, missing "
            << status.sequence_gaps << ", heard " << depths << " depths and " << points
            << " clouds; ms of CPU a frame: " << cpu.user_ms / sent << " in the program, "
            << cpu.system_ms / sent << " in the kernel\n"
            << output;
  // Best effort, on a machine that may have other things to do.
  EXPECT_GE(depths + points, sent) << output;
  EXPECT_LE(depths + points, status.frames_out);
  // Whatever the bus lost is counted, but for the last ones: only the next frame shows that.
  EXPECT_GE(status.frames_in + status.sequence_gaps, 2 * (sent - 2));
  EXPECT_EQ(status.frames_failed, 0);
  EXPECT_THAT(output,
              HasSubstr(std::to_string(int64_t{depths} * 2 * FeedGraph::kSize.area()) + " bytes"));
}

TEST(Ros2System, ShowsDepthAndPointsToThisHost) { ShowDepthAndPointsTo(Host()); }

TEST(Ros2System, ShowsDepthAndPointsToAnotherHost) {
  const OtherHost host;
  REQUIRE_HOST(host);
  ShowDepthAndPointsTo(host);
}

TEST(Ros2System, ASubscriberThatSleepsStopsNobody) {
  const OtherHost host;
  REQUIRE_HOST(host);
  FedGraph graph;
  graph.Start("ros2");
  const auto sleeper = host.Run(Hear("2", std::to_string(Seconds() + 4), /*reliable=*/true));
  const auto awake = host.Run(Hear(std::to_string(Seconds() + 4), "0", /*reliable=*/true));
  std::this_thread::sleep_for(2s);
  FeedGraph feed(graph);
  const int sent = feed.Run(Seconds());
  EXPECT_EQ(End(*awake), 0);
  EXPECT_EQ(End(*sleeper), 0);
  const long heard =
      Heard(awake->Output(), "/sprout/depth/image_rect") + Heard(awake->Output(), "/sprout/points");
  EXPECT_LE(Heard(sleeper->Output(), "/sprout/depth/image_rect"), 5);  // what its history keeps
  // The graph was not held up, and whatever was not delivered is counted.
  const StageStatus status = FinalStatus(graph);
  std::cout << "sent " << sent << " frames, came " << status.frames_in << " messages, heard "
            << heard << ", failed " << status.frames_failed << "\n";
  EXPECT_GE(status.frames_in, sent);
  EXPECT_GE(heard + status.frames_failed, status.frames_in) << awake->Output();
}

TEST(Ros2System, SaysThatNothingOfTheGraphComes) {
  Graph graph;
  graph.Start("ros2");
  EXPECT_TRUE(graph.WaitUntil([](Graph& g) {
    return g.statuses["ros2"].last_error.starts_with("nothing heard on SPROUT_RIG; heard in");
  }));
}

TEST(Ros2System, RefusesAFrameThatStandsInItself) {
  EXPECT_THAT(
      OutputOf({"sprout-ros2", "--config", "ros2 { left_frame: \"camera\" tof_frame: \"camera\" }"},
               2, 20s),
      HasSubstr("allowed are names that differ"));
}

TEST(Ros2System, RefusesADomainOfTheEnvironmentByItsName) {
  setenv("ROS_DOMAIN_ID", "robot", /*overwrite=*/1);
  EXPECT_THAT(OutputOf({"sprout-ros2"}, 2, 20s),
              HasSubstr("sprout-ros2: ROS_DOMAIN_ID = 'robot': allowed is 0 to 232"));
  unsetenv("ROS_DOMAIN_ID");
}

TEST(Ros2System, CountsFramesThatNeverCame) {
  const OtherHost host;
  REQUIRE_HOST(host);
  FedGraph graph;
  graph.Start("ros2");
  const auto peer = host.Run(Hear("9", "0", /*reliable=*/false));
  std::this_thread::sleep_for(2s);
  FeedGraph feed(graph);
  feed.Run(1);
  feed.Skip(3);
  feed.Run(1);
  // Of both channels.
  EXPECT_TRUE(graph.WaitUntil([](Graph& g) { return g.statuses.at("ros2").sequence_gaps >= 6; }))
      << graph.process("ros2").Output();
}

// Cyclone's own test of bad networks: of a thousand datagrams it does not send these, at random.
class LostDatagrams {
 public:
  explicit LostDatagrams(int per_thousand) {
    const std::string config = "<CycloneDDS><Domain><Internal><Test><XmitLossiness>" +
                               std::to_string(per_thousand) +
                               "</XmitLossiness></Test></Internal></Domain></CycloneDDS>";
    setenv("CYCLONEDDS_URI", config.c_str(), /*overwrite=*/1);
  }
  ~LostDatagrams() { unsetenv("CYCLONEDDS_URI"); }
};

TEST(Ros2System, ReliableTopicsSurviveLostDatagrams) {
  const OtherHost host;
  REQUIRE_HOST(host);
  const LostDatagrams one_percent(10);
  FedGraph graph;
  graph.Start("ros2");
  const auto peer = host.Run(Hear(kUntilTold, "0", /*reliable=*/true));
  std::this_thread::sleep_for(3s);
  FeedGraph feed(graph);
  const int sent = feed.Run(Seconds());
  std::this_thread::sleep_for(3s);  // what is sent again
  peer->Signal(SIGTERM);
  EXPECT_EQ(End(*peer), 0);
  const long heard =
      Heard(peer->Output(), "/sprout/depth/image_rect") + Heard(peer->Output(), "/sprout/points");
  const StageStatus status = FinalStatus(graph);
  std::cout << "1 % lost: sent " << sent << ", heard " << heard << ", failed "
            << status.frames_failed << "\n";
  EXPECT_GE(heard + status.frames_failed, status.frames_in);
}

}  // namespace
}  // namespace sprout
