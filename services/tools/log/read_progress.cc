#include "services/tools/log/read_progress.h"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

namespace sprout::log {
namespace {

constexpr std::chrono::milliseconds kPeriod{200};

}  // namespace

ReadProgress::ReadProgress(std::string what, int64_t bytes)
    : what_(std::move(what)), bytes_(bytes), next_(std::chrono::steady_clock::now() + kPeriod) {}

void ReadProgress::Update(int64_t position) {
  Interrupt::Check();
  const auto now = std::chrono::steady_clock::now();
  if (now < next_) return;
  next_ = now + kPeriod;
  line_.Show(fmt::format("{}: {} % of {:.1f} GB", what_,
                         100 * position / std::max<int64_t>(bytes_, 1),
                         static_cast<double>(bytes_) / 1e9));
}

}  // namespace sprout::log
