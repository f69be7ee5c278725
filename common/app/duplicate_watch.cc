#include "common/app/duplicate_watch.h"

namespace sprout {
namespace {

// Twins that are remembered; anybody can invent more.
constexpr size_t kMaxTwins = 32;

}  // namespace

void DuplicateWatch::Heard(const StageStatus& status) {
  ForgetSilentOnes();
  const StageStatus own = monitor_.Snapshot();
  if (status.stage != own.stage || (status.pid == own.pid && status.host == own.host)) return;
  const std::pair name(status.host, status.pid);
  const auto known = twins_.find(name);
  if (status.state == StageStatus::State::kStopped) {
    if (known == twins_.end()) return;
    monitor_.Resolve(known->second.warning);
    twins_.erase(known);
    return;
  }
  if (known != twins_.end()) {
    known->second.heard = now_();
    return;
  }
  if (twins_.size() == kMaxTwins) return;
  const std::string text = "another sprout-" + status.stage + " works on these channels, process " +
                           std::to_string(status.pid) + " on " + status.host +
                           ": stop one of the two, or give it another --channel-prefix";
  twins_[name] = {text, now_()};
  monitor_.Warn(text);
  monitor_.HoldWarning(text);
}

void DuplicateWatch::ForgetSilentOnes() {
  std::erase_if(twins_, [&](const auto& entry) {
    const Twin& twin = entry.second;
    if (now_() - twin.heard < kSilentFor) return false;
    monitor_.Resolve(twin.warning);
    return true;
  });
}

}  // namespace sprout
