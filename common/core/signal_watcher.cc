#include "common/core/signal_watcher.h"

#include <pthread.h>
#include <sys/time.h>
#include <ucontext.h>
#include <unistd.h>

#include <atomic>
#include <cstdint>
#include <utility>
#include <vector>

#include "common/core/sleep.h"

namespace sprout {
namespace {

using namespace std::chrono_literals;

// Wakes the watcher's thread so that it can end. Nothing else sends this signal, and by default it
// does nothing.
constexpr int kWake = SIGURG;

// The handler in threads that are older than the watcher: blocks the signal in this thread and
// sends it to the process again, until the watcher gets it. Only calls that handlers may make.
void PassOnToProcess(int signal, siginfo_t*, void* context) {
  sigaddset(&static_cast<ucontext_t*>(context)->uc_sigmask, signal);
  kill(getpid(), signal);
}

void PassOnInOtherThreads(int signal) {
  struct sigaction action {};
  action.sa_sigaction = PassOnToProcess;
  action.sa_flags = SA_SIGINFO | SA_RESTART;
  sigemptyset(&action.sa_mask);
  sigaction(signal, &action, nullptr);
}

// Sends SIGALRM after that time; 0: never.
void SetAlarm(std::chrono::microseconds time) {
  const itimerval alarm{
      .it_interval = {},
      .it_value = {.tv_sec = time.count() / 1'000'000, .tv_usec = time.count() % 1'000'000}};
  setitimer(ITIMER_REAL, &alarm, nullptr);
}

// Whether a signal is ignored, as SIGHUP where nohup started the process.
bool IsIgnored(int signal) {
  struct sigaction action {};
  return sigaction(signal, nullptr, &action) == 0 && action.sa_handler == SIG_IGN;
}

volatile std::sig_atomic_t came = 0;

std::atomic<int64_t> first_ns = 0;  // when it came

int64_t NowNs() { return std::chrono::steady_clock::now().time_since_epoch() / 1ns; }

// What comes so soon after the first signal is the same wish: timeout(1) sends one to the process
// and another one to its group.
void EndAtSecond(int signal) {
  if (NowNs() - first_ns < 100ms / 1ns) return;
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

}  // namespace

SignalWatcher::SignalWatcher(std::chrono::microseconds grace, std::function<void(int)> told)
    : grace_(grace), told_(std::move(told)) {
  sigemptyset(&signals_);
  std::vector<int> endings = {SIGINT, SIGTERM};
  if (!IsIgnored(SIGHUP)) endings.push_back(SIGHUP);
  sigaddset(&signals_, kWake);
  for (const int ending : endings) sigaddset(&signals_, ending);
  pthread_sigmask(SIG_BLOCK, &signals_, nullptr);
  for (const int ending : endings) PassOnInOtherThreads(ending);
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
  first_ns = NowNs();
  // Whoever started this process may have told it to ignore or block them.
  for (const int ending : {SIGINT, SIGTERM}) std::signal(ending, EndAtSecond);
  std::signal(SIGALRM, SIG_DFL);
  // A terminal that goes sends one, and its shell another one.
  std::signal(SIGHUP, SIG_IGN);
  sigaddset(&signals_, SIGALRM);
  SetAlarm(grace_);
  pthread_sigmask(SIG_UNBLOCK, &signals_, nullptr);
  source_.request_stop();
  if (told_) told_(signal);
  // Stays here for the second signal: the other threads do not take it.
  while (SleepFor(std::chrono::hours(1), stop)) {
  }
}

Interrupt::Interrupt() {
  came = 0;
  for (const int signal : {SIGINT, SIGTERM}) {
    std::signal(signal, [](int number) {
      if (came != 0) return EndAtSecond(number);
      first_ns = NowNs();
      came = 1;
    });
  }
}

Interrupt::~Interrupt() {
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, SIG_DFL);
}

bool Interrupt::requested() { return came != 0; }

}  // namespace sprout
