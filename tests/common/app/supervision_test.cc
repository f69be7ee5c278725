#include "common/app/supervision.h"

#include <gmock/gmock.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <thread>
#include <vector>

#include "common/app/log.h"
#include "tests/common/picture/temporary_directory.h"

namespace sprout {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

HangLimit WithFrames(size_t count, HangLimit::Duration frame) {
  HangLimit limit(seconds(20));
  for (size_t i = 0; i < count; ++i) limit.Add(frame);
  return limit;
}

TEST(HangLimit, IsTheLongestUntilFramesAreKnown) {
  EXPECT_EQ(WithFrames(0, {}).limit(), seconds(20));
  EXPECT_EQ(WithFrames(HangLimit::kFramesToTrust - 1, milliseconds(10)).limit(), seconds(20));
}

TEST(HangLimit, IsASecondForAFastStage) {
  EXPECT_EQ(WithFrames(10, milliseconds(100)).limit(), seconds(1));
  EXPECT_EQ(WithFrames(10, milliseconds(250)).limit(), seconds(1));
}

TEST(HangLimit, IsFourTimesTheSlowestFrameOfASlowStage) {
  EXPECT_EQ(WithFrames(10, milliseconds(251)).limit(), milliseconds(1250));
  HangLimit limit = WithFrames(10, milliseconds(100));
  limit.Add(seconds(2));
  EXPECT_EQ(limit.limit(), seconds(8));
}

TEST(HangLimit, NeverExceedsTheLongest) {
  EXPECT_EQ(WithFrames(10, seconds(7)).limit(), seconds(20));
}

TEST(HangLimit, ForgetsASlowFrame) {
  HangLimit limit = WithFrames(10, seconds(2));
  for (size_t i = 1; i < HangLimit::kFramesToRemember; ++i) limit.Add(milliseconds(100));
  EXPECT_EQ(limit.limit(), seconds(8));
  limit.Add(milliseconds(100));
  EXPECT_EQ(limit.limit(), seconds(1));
}

// A service manager: the socket that systemd gives to a unit of Type=notify.
class ServiceManager {
 public:
  explicit ServiceManager(const std::string& watchdog_us) {
    socket_ = socket(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK, 0);
    sockaddr_un address{.sun_family = AF_UNIX, .sun_path = {}};  // the kernel picks a name
    EXPECT_EQ(bind(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address.sun_family), 0);
    socklen_t length = sizeof address;
    getsockname(socket_, reinterpret_cast<sockaddr*>(&address), &length);
    const size_t name_length = length - offsetof(sockaddr_un, sun_path) - 1;
    setenv("NOTIFY_SOCKET", ("@" + std::string(address.sun_path + 1, name_length)).c_str(), 1);
    if (!watchdog_us.empty()) setenv("WATCHDOG_USEC", watchdog_us.c_str(), 1);
  }

  ~ServiceManager() {
    unsetenv("NOTIFY_SOCKET");
    unsetenv("WATCHDOG_USEC");
    close(socket_);
  }

  ServiceManager(const ServiceManager&) = delete;
  ServiceManager& operator=(const ServiceManager&) = delete;

  // What it was told since the last call.
  std::vector<std::string> Heard() const {
    std::vector<std::string> heard;
    char text[1000];
    ssize_t size = 0;
    while ((size = recv(socket_, text, sizeof text, 0)) > 0) {
      heard.emplace_back(text, static_cast<size_t>(size));
    }
    return heard;
  }

 private:
  int socket_;
};

TEST(Supervision, IsToldOfReadinessAndStatus) {
  const ServiceManager manager("");
  NotifyReady();
  EXPECT_THAT(manager.Heard(), ElementsAre("READY=1"));
  StageStatus status;
  status.frames_out = 12;
  status.frames_skipped = 3;
  status.rate_hz = 9.96;
  NotifyStatus(status);
  EXPECT_THAT(manager.Heard(),
              ElementsAre(::testing::HasSubstr("STATUS=12 frames, 10.0 a second, 3 skipped")));
}

TEST(Supervision, TellsASocketWithAPath) {
  const TemporaryDirectory folder;
  const std::string path = folder / "notify";
  const int manager = socket(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK, 0);
  sockaddr_un address{.sun_family = AF_UNIX, .sun_path = {}};
  ASSERT_LT(path.size(), sizeof address.sun_path);
  std::ranges::copy(path, address.sun_path);
  ASSERT_EQ(bind(manager, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  setenv("NOTIFY_SOCKET", path.c_str(), 1);
  NotifyReady();
  unsetenv("NOTIFY_SOCKET");
  char text[100] = {};
  EXPECT_EQ(recv(manager, text, sizeof text - 1, 0), 7);
  EXPECT_STREQ(text, "READY=1");
  close(manager);
}

TEST(Supervision, AWatchdogOfAnotherProcessIsNotOurs) {
  const ServiceManager manager("20000000");
  setenv("WATCHDOG_PID", "1", 1);
  Watchdog watchdog;
  unsetenv("WATCHDOG_PID");
  watchdog.Idle();
  EXPECT_THAT(manager.Heard(), IsEmpty());
}

// systemd reads the level of each line of stderr from its beginning.
TEST(Supervision, LinesForTheJournalHaveTheirLevel) {
  testing::internal::CaptureStderr();
  SetUpLog("probe", LogLevel::kInfo, /*to_journal=*/true);
  LogLine(LogLevel::kWarning, "one\ntwo");
  LogLine(LogLevel::kDebug, "not this");
  LogLine(LogLevel::kInfo, "three");
  LogLine(LogLevel::kError, "four");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "<4>one\n<4>two\n<6>three\n<3>four\n");
  SetUpLog("probe", LogLevel::kInfo, /*to_journal=*/false);
}

TEST(Supervision, WatchdogIsSilentWhenNobodyWatches) {
  const ServiceManager manager("");
  Watchdog watchdog;
  watchdog.Idle();
  watchdog.FrameDone();
  EXPECT_THAT(manager.Heard(), IsEmpty());
}

TEST(Supervision, WatchdogShowsLifeAndAsksForLessTimeOnceFramesAreKnown) {
  const ServiceManager manager("20000000");
  Watchdog watchdog;
  watchdog.Idle();
  watchdog.Idle();
  EXPECT_THAT(manager.Heard(), ElementsAre("WATCHDOG=1")) << "not at every call";
  for (size_t i = 1; i < HangLimit::kFramesToTrust; ++i) {
    watchdog.FrameDone();
    EXPECT_THAT(manager.Heard(), ElementsAre("WATCHDOG=1"));
  }
  watchdog.FrameDone();
  EXPECT_THAT(manager.Heard(), ElementsAre("WATCHDOG_USEC=1000000", "WATCHDOG=1"));
  watchdog.FrameDone();
  EXPECT_THAT(manager.Heard(), ElementsAre("WATCHDOG=1")) << "only when it changes";
}

TEST(Supervision, WatchdogCountsWaitingNotAsWork) {
  const ServiceManager manager("20000000");
  Watchdog watchdog;
  for (size_t i = 1; i < HangLimit::kFramesToTrust; ++i) {
    watchdog.FrameDone();
    manager.Heard();  // its socket holds ten messages
  }
  std::this_thread::sleep_for(milliseconds(600));
  watchdog.Idle();
  watchdog.FrameDone();
  EXPECT_THAT(manager.Heard(), ::testing::Contains("WATCHDOG_USEC=1000000"));
}

}  // namespace
}  // namespace sprout
