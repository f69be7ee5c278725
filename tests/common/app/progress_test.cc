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
  Terminal() : before_(dup(STDERR_FILENO)) {
    int slave = -1;
    EXPECT_EQ(openpty(&master_, &slave, nullptr, nullptr, nullptr), 0);
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
