#include "services/log/read_progress.h"

#include <fmt/format.h>

#include <algorithm>
#include <csignal>
#include <utility>

namespace sprout::log {
namespace {

constexpr std::chrono::milliseconds kPeriod{200};

volatile std::sig_atomic_t interrupted = 0;

}  // namespace

ReadProgress::ReadProgress(std::string what, int64_t bytes)
    : what_(std::move(what)), bytes_(bytes), next_(std::chrono::steady_clock::now() + kPeriod) {
  interrupted = 0;
  std::signal(SIGINT, [](int) { interrupted = 1; });
}

ReadProgress::~ReadProgress() { std::signal(SIGINT, SIG_DFL); }

void ReadProgress::Update(int64_t position) {
  if (interrupted != 0) throw Interrupted();
  const auto now = std::chrono::steady_clock::now();
  if (now < next_) return;
  next_ = now + kPeriod;
  line_.Show(fmt::format("{}: {} % of {:.1f} GB", what_,
                         100 * position / std::max<int64_t>(bytes_, 1),
                         static_cast<double>(bytes_) / 1e9));
}

}  // namespace sprout::log
