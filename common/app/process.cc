#include "common/app/process.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <climits>
#include <csignal>
#include <stdexcept>
#include <utility>

namespace sprout {
namespace {

struct Pipe {
  Pipe() {
    std::array<int, 2> ends{};
    if (pipe2(ends.data(), O_CLOEXEC) != 0) throw std::runtime_error("no pipe left");
    to_read = ends[0];
    to_write = ends[1];
  }
  // Closes the ends that nothing took over.
  ~Pipe() {
    for (const int end : {to_read, to_write}) {
      if (end >= 0) close(end);
    }
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  int to_read;
  int to_write;
};

// Between fork() and here only calls that are safe there, since this program may have threads.
// Begins once it has a guard: nobody would end it if its parent were killed before.
[[noreturn]] void BecomeProgram(char** arguments, int output, const Pipe& guarded) {
  setpgid(0, 0);
  close(guarded.to_write);
  char nothing = 0;
  if (read(guarded.to_read, &nothing, 1) != 1) _exit(127);
  dup2(output, STDOUT_FILENO);
  dup2(output, STDERR_FILENO);
  execvp(arguments[0], arguments);
  _exit(127);
}

// Kills a process group when the other end of a pipe closes.
[[noreturn]] void BecomeGuard(pid_t group, int pipe) {
  setpgid(0, 0);  // Ctrl-C is not for it
  dup2(pipe, STDIN_FILENO);
  close_range(STDIN_FILENO + 1, UINT_MAX, 0);
  char nothing = 0;
  while (read(STDIN_FILENO, &nothing, 1) != 0) continue;
  kill(-group, SIGKILL);
  _exit(0);
}

}  // namespace

Process::Process(const std::vector<std::string>& command) {
  std::vector<char*> arguments;
  arguments.reserve(command.size() + 1);
  for (const std::string& argument : command) {
    arguments.push_back(const_cast<char*>(argument.c_str()));
  }
  arguments.push_back(nullptr);
  Pipe output;
  Pipe life;
  Pipe guarded;
  pid_ = fork();
  if (pid_ == 0) BecomeProgram(arguments.data(), output.to_write, guarded);
  if (pid_ > 0) {
    setpgid(pid_, pid_);  // whoever of the two is first
    guard_pid_ = fork();
    if (guard_pid_ == 0) BecomeGuard(pid_, life.to_read);
  }
  if (guard_pid_ < 0) {
    if (pid_ > 0 && kill(-pid_, SIGKILL) == 0) waitpid(pid_, nullptr, 0);
    throw std::runtime_error("no process left");
  }
  if (write(guarded.to_write, "", 1) != 1) throw std::runtime_error("a pipe that takes no byte");
  output_pipe_ = std::exchange(output.to_read, -1);
  life_pipe_ = std::exchange(life.to_write, -1);
  fcntl(output_pipe_, F_SETFL, O_NONBLOCK);
  reader_ = std::jthread([this](const std::stop_token& stop) {
    constexpr int kPollMs = 20;
    pollfd readable{.fd = output_pipe_, .events = POLLIN, .revents = 0};
    while (!stop.stop_requested()) {
      if (poll(&readable, 1, kPollMs) > 0) ReadOutput();
      if ((readable.revents & (POLLIN | POLLHUP)) == POLLHUP) return;
    }
  });
}

Process::~Process() {
  if (!exit_code_) {
    Signal(SIGKILL);
    Wait();
  }
  reader_.request_stop();
  reader_.join();
  close(output_pipe_);
  close(life_pipe_);
}

void Process::Signal(int signal) {
  if (!exit_code_) kill(pid_, signal);
}

std::optional<int> Process::Wait(std::chrono::milliseconds timeout) {
  const auto deadline = std::chrono::steady_clock::now() + timeout;
  while (!exit_code_) {
    siginfo_t info{};
    waitid(P_PID, static_cast<id_t>(pid_), &info, WEXITED | WNOHANG | WNOWAIT);
    if (info.si_pid == pid_) {
      exit_code_ = info.si_code == CLD_EXITED ? info.si_status : 128 + info.si_status;
      kill(-pid_, SIGKILL);  // what it started and left behind, while its number is still taken
      kill(guard_pid_, SIGKILL);
      waitpid(pid_, nullptr, 0);
      waitpid(guard_pid_, nullptr, 0);
    } else if (std::chrono::steady_clock::now() > deadline) {
      return std::nullopt;
    } else {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
  }
  return exit_code_;
}

// Reads what the pipe can hold once, so that an endless writer keeps nobody waiting.
void Process::ReadOutput() {
  const std::lock_guard lock(mutex_);
  std::array<char, 65536> chunk;
  const ssize_t count = read(output_pipe_, chunk.data(), chunk.size());
  if (count <= 0) return;
  output_.append(chunk.data(), static_cast<size_t>(count));
  if (output_.size() > 2 * kOutputBytes) output_.erase(0, output_.size() - kOutputBytes);
}

std::string Process::Output() {
  ReadOutput();
  const std::lock_guard lock(mutex_);
  return output_.size() > kOutputBytes ? output_.substr(output_.size() - kOutputBytes) : output_;
}

}  // namespace sprout
