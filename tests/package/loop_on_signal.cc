// Preloaded (LD_PRELOAD) into a stage as it ships: SIGUSR1 sends its main thread, which is the one
// that works on frames, into an endless loop, as a bug might. Receiving and reporting go on.
#include <unistd.h>

#include <csignal>

namespace {

void Loop(int signal) {
  if (gettid() != getpid()) {  // another thread took it
    tgkill(getpid(), getpid(), signal);
    return;
  }
  volatile bool forever = true;
  while (forever) {
  }
}

[[maybe_unused]] const bool kInstalled = std::signal(SIGUSR1, &Loop) != SIG_ERR;

}  // namespace
