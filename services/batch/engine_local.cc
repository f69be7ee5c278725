#include <fmt/core.h>

#include <cerrno>
#include <csignal>
#include <deque>
#include <iostream>
#include <mutex>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <thread>

#include "common/app/process.h"
#include "common/app/progress.h"
#include "common/core/interrupt.h"
#include "services/batch/engines.h"
#include "services/batch/shard_try.h"

namespace sprout::batch {
namespace {

using Clock = std::chrono::steady_clock;

// Shards waiting for a worker.
class Queue {
 public:
  Queue(const Manifest& manifest, const BatchState& state, int retries) : retries_(retries) {
    for (size_t i = 0; i < state.done.size(); ++i) {
      if (state.done[i]) continue;
      waiting_.push_back({i, 0});
      frames_to_do_ += manifest.shards[i].frames;
    }
    missing_ = std::ssize(waiting_);
  }

  struct Item {
    size_t shard;
    int failures;
  };

  std::optional<Item> Take() {
    const std::lock_guard lock(mutex_);
    if (waiting_.empty() || !stopped_.empty() || Interrupt::requested()) return std::nullopt;
    const Item item = waiting_.front();
    waiting_.pop_front();
    return item;
  }

  void Done(int64_t frames) {
    const std::lock_guard lock(mutex_);
    --missing_;
    frames_done_ += frames;
  }

  void Failed(Item item, const std::string& output, Progress& progress) {
    const std::lock_guard lock(mutex_);
    progress.Clear();
    const bool again = item.failures < retries_;
    std::cerr << "sprout-batch: " << output
              << (again ? "; will be tried again\n" : "; that was the last try\n");
    if (again) waiting_.push_back({item.shard, item.failures + 1});
  }

  // What failed for a reason that every other shard would meet, too.
  void Stop(const std::string& output) {
    const std::lock_guard lock(mutex_);
    if (stopped_.empty()) stopped_ = output;
  }

  void Show(Progress& progress) {
    const std::lock_guard lock(mutex_);
    const double seconds = std::chrono::duration<double>(Clock::now() - start_).count();
    const double rate = static_cast<double>(frames_done_) / seconds;
    std::string text =
        fmt::format("{} shards and {} frames to go", missing_, frames_to_do_ - frames_done_);
    if (frames_done_ > 0) {
      text += fmt::format(", {:.1f} frames/s, {:.0f} min left", rate,
                          static_cast<double>(frames_to_do_ - frames_done_) / rate / 60);
    }
    progress.Show(text);
  }

  int64_t missing() const { return missing_; }
  const std::string& stopped() const { return stopped_; }  // why; empty: it was not

 private:
  std::mutex mutex_;
  std::deque<Item> waiting_;
  int retries_;
  std::string stopped_;
  int64_t missing_ = 0;
  int64_t frames_to_do_ = 0;
  int64_t frames_done_ = 0;
  Clock::time_point start_ = Clock::now();
};

// The line in which a shard's process says why it failed.
std::string ReasonIn(std::string output) {
  constexpr std::string_view kName = "sprout-batch: ";
  while (output.ends_with('\n')) output.pop_back();
  if (output.starts_with(kName)) output.erase(0, kName.size());
  return output;
}

// A program that was exchanged, or a full disk.
bool IsHopeless(int code, const std::string& why) {
  return code == 2 || why.find(std::generic_category().message(ENOSPC)) != std::string::npos;
}

}  // namespace

int64_t RunLocal(const std::string& program, const BatchFolder& folder, const Manifest& manifest,
                 const BatchState& state, const LocalOptions& options) {
  Queue queue(manifest, state, options.retries);
  Progress progress(/*quiet=*/false);
  const auto work = [&] {
    while (const auto item = queue.Take()) {
      queue.Show(progress);
      Process process({program, "run-shard", folder.root(), std::to_string(item->shard)});
      std::optional<int> code;
      while (!(code = process.Wait(std::chrono::seconds(1)))) {
        if (Interrupt::requested()) process.Signal(SIGTERM);
      }
      if (code == 0) {
        queue.Done(manifest.shards[item->shard].frames);
      } else if (Interrupt::requested()) {
        ForgetTry(folder, item->shard);
      } else if (const std::string why = ReasonIn(process.Output()); IsHopeless(*code, why)) {
        queue.Stop(why);
      } else {
        queue.Failed(*item, why, progress);
      }
    }
  };
  const unsigned cores = std::max(1U, std::thread::hardware_concurrency());
  {
    std::vector<std::jthread> workers;
    for (int i = 0; i < (options.jobs > 0 ? options.jobs : static_cast<int>(cores)); ++i) {
      workers.emplace_back(work);
    }
  }
  progress.Clear();
  Interrupt::Check();
  if (!queue.stopped().empty()) {
    throw std::runtime_error(queue.stopped() + "; the same command continues from here");
  }
  return queue.missing();
}

}  // namespace sprout::batch
