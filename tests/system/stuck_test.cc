#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/stat.h>

#include <csignal>
#include <filesystem>

#include "tests/common/bus/fake_tcpq_server.h"
#include "tests/common/picture/temporary_directory.h"
#include "tests/common/scenes/scene_folder.h"
#include "tests/system/graph.h"
#include "tests/system/run_program.h"

// Processes that wait for something that never comes: a signal must end them. And a lost server.
namespace sprout {
namespace {

namespace fs = std::filesystem;

// Time until supervisors kill a process.
constexpr std::chrono::seconds kPatience{2};

fs::path MakeFifo(const fs::path& path) {
  if (mkfifo(path.c_str(), 0600) != 0) throw std::runtime_error("no FIFO " + path.string());
  return path;
}

// Opens for writing, and writes nothing; true once somebody reads there.
bool IsRead(const fs::path& fifo) { return open(fifo.c_str(), O_WRONLY | O_NONBLOCK) >= 0; }

void ExpectEndsOnSigterm(const std::vector<std::string>& command, const fs::path& fifo) {
  Process process(command);
  const std::chrono::seconds no_time{0};
  ASSERT_TRUE(Eventually([&] { return IsRead(fifo) || process.Wait(no_time); }))
      << process.Output();
  process.Signal(SIGTERM);
  EXPECT_TRUE(process.Wait(kPatience)) << command[0] << " " << command[1];
}

TEST(StuckSystem, NobodyWaitsForALogThatIsAFifo) {
  const TemporaryDirectory folder;
  const fs::path fifo = MakeFifo(folder / "fifo");
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{"sprout-grow", "--replay", fifo, "--record", folder / "out.lcm"},
        {"sprout-capture", "--source", "log:" + fifo.string()}}) {
    EXPECT_THAT(OutputOf(command, 2, kPatience), testing::HasSubstr("not a file")) << command[0];
  }
}

TEST(StuckSystem, ASignalEndsWhoReadsASceneWithAFifoInIt) {
  const scenes::SceneFolder scene(cv::Size(413, 370));
  const fs::path fifo = MakeFifo(scene.File("dmin.txt"));
  ExpectEndsOnSigterm({ProgramPath("sprout-capture"), "--source", scene.Config().source()}, fifo);
}

TEST(StuckSystem, CaptureCountsAFrameThatItsServerNeverTookAsNotSent) {
  FakeTcpqServer server;
  Process capture({ProgramPath("sprout-capture"), "--lcm-url", server.url(), "--source",
                   "synthetic:64x48", "--rate", "0", "--frames", "2"});
  // The frames', the answers' and the status' connection.
  for (int connection = 0; connection < 3; ++connection) {
    ASSERT_TRUE(server.Accept());
    if (connection == 0) server.Disconnect();
  }
  server.Close();
  EXPECT_EQ(capture.Wait(std::chrono::seconds(30)), 1);
  EXPECT_THAT(capture.Output(), testing::HasSubstr("sent 0 frames"));
  EXPECT_THAT(capture.Output(), testing::HasSubstr("; 2 could not be sent"));
}

TEST(StuckSystem, ASignalEndsWhoseServerTakesNoMore) {
  FakeTcpqServer server;
  Process capture({ProgramPath("sprout-capture"), "--lcm-url", server.url(), "--source",
                   "synthetic:640x480", "--rate", "0", "--log-level", "debug"});
  // The frames', the answers' and the status' connection. None of them is ever read.
  for (int connection = 0; connection < 3; ++connection) ASSERT_TRUE(server.Accept());
  // Until the buffers between are full: then no line says any more that a frame was sent.
  size_t said = 0;
  int unchanged = 0;
  ASSERT_TRUE(Eventually([&] {
    const size_t now = capture.Output().size();
    unchanged = now == said ? unchanged + 1 : 0;
    said = now;
    return unchanged > 50;
  }));
  capture.Signal(SIGTERM);
  EXPECT_TRUE(capture.Wait(kPatience)) << capture.Output();
}

}  // namespace
}  // namespace sprout
