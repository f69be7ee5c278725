#include "common/core/signal_watcher.h"

#include <pthread.h>
#include <sys/time.h>

#include <utility>

#include "common/core/sleep.h"

namespace sprout {
namespace {

// Makes the thread look whether it is over. Nobody else sends it, and where it is not waited for it
// does nothing.
constexpr int kWake = SIGURG;

// 0: never.
void SetAlarm(std::chrono::microseconds time) {
  const itimerval alarm{
      .it_interval = {},
      .it_value = {.tv_sec = time.count() / 1'000'000, .tv_usec = time.count() % 1'000'000}};
  setitimer(ITIMER_REAL, &alarm, nullptr);
}

}  // namespace

SignalWatcher::SignalWatcher(std::chrono::microseconds grace, std::function<void(int)> told)
    : grace_(grace), told_(std::move(told)) {
  sigemptyset(&signals_);
  for (const int signal : {SIGINT, SIGTERM, kWake}) sigaddset(&signals_, signal);
  pthread_sigmask(SIG_BLOCK, &signals_, nullptr);
  thread_ = std::jthread([this](const std::stop_token& stop) { Watch(stop); });
}

SignalWatcher::~SignalWatcher() {
  thread_.request_stop();
  pthread_kill(thread_.native_handle(), kWake);
  thread_.join();
  SetAlarm({});
}

void SignalWatcher::Watch(const std::stop_token& stop) {
  int signal = kWake;
  while (signal == kWake) {
    if (stop.stop_requested()) return;
    sigwait(&signals_, &signal);
  }
  // Whoever started this process may have told it to ignore or block them.
  for (const int ending : {SIGINT, SIGTERM, SIGALRM}) std::signal(ending, SIG_DFL);
  sigaddset(&signals_, SIGALRM);
  SetAlarm(grace_);
  pthread_sigmask(SIG_UNBLOCK, &signals_, nullptr);
  source_.request_stop();
  if (told_) told_(signal);
  // Stays here for the second signal: the other threads do not take it.
  while (SleepFor(std::chrono::hours(1), stop)) {
  }
}

}  // namespace sprout
