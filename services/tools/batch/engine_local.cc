#include <fmt/core.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <iostream>
#include <mutex>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <thread>

#include "common/app/process.h"
#include "common/app/progress.h"
#include "common/core/signal_watcher.h"
#include "services/tools/batch/engines.h"
#include "services/tools/batch/log_task.h"

namespace sprout::batch {
namespace {

// The line in which the process of a log says why it failed: the last one, after the warnings.
std::string ReasonIn(std::string output) {
  constexpr std::string_view kName = "sprout-batch: ";
  while (output.ends_with('\n')) output.pop_back();
  const size_t at = output.rfind(kName);
  return at == std::string::npos ? output : output.substr(at + kName.size());
}

// Whether every other log would fail, too: a program was replaced, or the disk is full.
bool ConcernsAllLogs(int code, const std::string& why) {
  return code == 2 || why.find(std::generic_category().message(ENOSPC)) != std::string::npos;
}

class LocalRun {
 public:
  LocalRun(const std::string& program, const BatchFolder& folder, const LocalOptions& options,
           std::vector<int> logs)
      : program_(program), folder_(folder), options_(options), logs_(std::move(logs)) {}

  // @throws std::runtime_error, Interrupted.
  void Run() {
    const int cores = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
    const int workers = std::clamp(options_.jobs > 0 ? options_.jobs : cores, 1,
                                   std::max(1, static_cast<int>(logs_.size())));
    threads_ = std::max(1, cores / workers);
    {
      std::vector<std::jthread> pool;
      for (int i = 0; i < workers; ++i) pool.emplace_back([this] { Work(); });
    }
    progress_.Clear();
    Interrupt::Check();
    if (!stopped_.empty()) {
      throw std::runtime_error(stopped_ + "; the same command continues from here");
    }
  }

 private:
  void Work() {
    for (size_t i = next_++; i < logs_.size(); i = next_++) {
      for (int failures = 0; !IsStopped() && !Try(logs_[i], failures); ++failures) {
        if (failures == options_.retries) break;
      }
      const std::lock_guard lock(mutex_);
      progress_.Show(fmt::format("{} of {} logs", ++ended_, logs_.size()));
    }
  }

  bool IsStopped() {
    const std::lock_guard lock(mutex_);
    return !stopped_.empty() || Interrupt::requested();
  }

  // @returns whether it succeeded.
  bool Try(int log, int failures) {
    try {
      return TryOrThrow(log, failures);
    } catch (const std::exception& e) {  // no process or pipe left
      const std::lock_guard lock(mutex_);
      if (stopped_.empty()) stopped_ = e.what();
      return false;
    }
  }

  bool TryOrThrow(int log, int failures) {
    Process process({program_, "compute", folder_.root(), std::to_string(log), "--threads",
                     std::to_string(threads_)});
    std::optional<int> code;
    while (!(code = process.Wait(std::chrono::milliseconds(50)))) {
      if (Interrupt::requested()) process.Signal(SIGTERM);
    }
    if (code == 0) return true;
    if (Interrupt::requested()) {
      ForgetTry(folder_, log);
      return false;
    }
    const std::string why = ReasonIn(process.Output());
    const std::lock_guard lock(mutex_);
    if (ConcernsAllLogs(*code, why)) {
      stopped_ = why;
      return false;
    }
    progress_.Clear();
    std::cerr << "sprout-batch: " << why
              << (failures < options_.retries ? "; will be tried again\n"
                                              : "; that was the last try\n");
    return false;
  }

  const std::string& program_;
  const BatchFolder& folder_;
  const LocalOptions& options_;
  std::vector<int> logs_;
  int threads_ = 1;
  std::atomic<size_t> next_ = 0;
  std::mutex mutex_;  // guards the members below
  Progress progress_{/*quiet=*/false};
  size_t ended_ = 0;
  std::string stopped_;  // why the run was stopped; empty: it was not
};

}  // namespace

void RunLocal(const std::string& program, const BatchFolder& folder, const BatchState& state,
              const LocalOptions& options) {
  std::vector<int> missing;
  for (size_t i = 0; i < state.done.size(); ++i) {
    if (!state.done[i]) missing.push_back(static_cast<int>(i));
  }
  LocalRun(program, folder, options, std::move(missing)).Run();
}

}  // namespace sprout::batch
