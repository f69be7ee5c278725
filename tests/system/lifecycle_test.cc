#include <gmock/gmock.h>

#include <csignal>

#include "tests/system/graph.h"
#include "tests/system/run_program.h"

namespace sprout {
namespace {

using testing::HasSubstr;

TEST(LifecycleSystem, SignalsEndEveryServiceCleanly) {
  for (const int signal : {SIGINT, SIGTERM}) {
    Graph graph;
    for (const char* stage : {"refine", "prior", "grow", "capture"}) {
      Process& process = graph.Start(stage);
      process.Signal(signal);
      EXPECT_EQ(process.Wait(std::chrono::seconds(5)), 0) << stage << "\n" << process.Output();
      EXPECT_TRUE(graph.WaitUntil([&](Graph& g) {
        return g.statuses[stage].state == StageStatus::State::kStopped;
      })) << stage;
    }
  }
}

TEST(LifecycleSystem, StatusComesOnceASecond) {
  Graph graph;
  int count = 0;
  std::string last;
  graph.Start("prior");
  const auto start = std::chrono::steady_clock::now();
  // rss changes little, so count by watching the map being overwritten.
  graph.WaitUntil(
      [&](Graph& g) {
        if (g.statuses.contains("prior")) {
          ++count;
          g.statuses.erase("prior");
        }
        return count >= 4;
      },
      std::chrono::seconds(10));
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  EXPECT_GE(count, 4);
  EXPECT_GE(seconds, 2.5);
  EXPECT_LE(seconds, 8);
}

TEST(LifecycleSystem, WithoutAMulticastRouteAServiceSaysHowToAddOne) {
  // One more network inside ours, with nothing but a loopback device.
  for (const char* stage : {"capture", "refine", "prior", "grow"}) {
    EXPECT_THAT(OutputOf({"unshare", "--net", "sh", "-c", "ip link set lo up && exec \"$0\"",
                          ProgramPath(std::string("sprout-") + stage)},
                         1, std::chrono::seconds(15)),
                HasSubstr(": no multicast route to 239.255.76.67; add one: ip "));
  }
}

TEST(LifecycleSystem, WithoutARouteToOtherHostsItIsNotLedOverTheLoopbackDevice) {
  EXPECT_THAT(
      OutputOf({"unshare", "--net", "sh", "-c", "ip link set lo up && exec \"$0\" \"$@\"",
                ProgramPath("sprout-prior"), "--lcm-url", "udpm://239.255.76.67:7667?ttl=1"},
               1, std::chrono::seconds(15)),
      HasSubstr("add one: ip route add 239.255.76.67/32 dev DEVICE, "));
}

TEST(LifecycleSystem, CaptureSaysWhichStageIsMissing) {
  Graph graph;
  graph.Start("refine");
  Process& capture =
      graph.StartOnly("capture", {"--wait-for", "refine,prior", "--wait-timeout", "2"});
  EXPECT_EQ(capture.Wait(), 1);
  EXPECT_THAT(capture.Output(),
              HasSubstr("no status from stage 'prior' in 2 s; those of refine came;"));
  EXPECT_THAT(capture.Output(), testing::Not(HasSubstr("stage 'refine'")));
}

}  // namespace
}  // namespace sprout
