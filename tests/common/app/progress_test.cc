#include "common/app/progress.h"

#include <gmock/gmock.h>
#include <poll.h>
#include <pty.h>
#include <unistd.h>

namespace sprout {
namespace {

using ::testing::HasSubstr;

// stderr is a terminal as long as it lives.
class Terminal {
 public:
  explicit Terminal(uint16_t columns = 80) : before_(dup(STDERR_FILENO)) {
    int slave = -1;
    const winsize size{.ws_row = 24, .ws_col = columns, .ws_xpixel = 0, .ws_ypixel = 0};
    EXPECT_EQ(openpty(&master_, &slave, nullptr, nullptr, &size), 0);
    dup2(slave, STDERR_FILENO);
    close(slave);
  }

  ~Terminal() {
    dup2(before_, STDERR_FILENO);
    close(before_);
    close(master_);
  }

  // What is written until `text` comes, or for five seconds.
  std::string ReadUntil(const std::string& text) const {
    std::string all;
    pollfd ready{.fd = master_, .events = POLLIN, .revents = 0};
    while (all.find(text) == std::string::npos && poll(&ready, 1, 5000) == 1) {
      char bytes[1000];
      const ssize_t count = read(master_, bytes, sizeof bytes);
      if (count <= 0) break;
      all.append(bytes, static_cast<size_t>(count));
    }
    return all;
  }

 private:
  int before_;
  int master_ = -1;
};

TEST(Progress, TellsForHowLongSomethingTakesAndErasesIt) {
  const Terminal terminal;
  Progress progress(/*quiet=*/false);
  progress.ShowTime("computing left.png");
  EXPECT_THAT(terminal.ReadUntil("computing left.png, 1 s"), HasSubstr("computing left.png, 1 s"));
  progress.Show("writing");
  EXPECT_THAT(terminal.ReadUntil("writing"), ::testing::Not(HasSubstr("2 s")));
  progress.Clear();
  EXPECT_THAT(terminal.ReadUntil("\r\x1b[K"), HasSubstr("\r\x1b[K"));
}

TEST(Progress, FillsOneLineOfANarrowTerminal) {
  const Terminal terminal(10);
  Progress progress(/*quiet=*/false);
  progress.Show("\u00fcber a long way|");
  progress.ShowTime("a long way");
  EXPECT_THAT(terminal.ReadUntil(", 1 s"),
              HasSubstr("\r\x1b[K\u00fcber a lo\r\x1b[Ka long wa\r\x1b[Ka lo, 1 s"));
}

TEST(Progress, WritesNothingWhereThereIsNoTerminal) {
  ::testing::internal::CaptureStderr();
  {
    Progress progress(/*quiet=*/false);
    progress.Show("a");
    progress.ShowTime("b");
  }
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
}

}  // namespace
}  // namespace sprout
