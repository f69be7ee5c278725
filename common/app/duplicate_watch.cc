#include "common/app/duplicate_watch.h"

namespace sprout {
namespace {

// Twins that are remembered; anybody can invent more.
constexpr size_t kMaxTwins = 32;

}  // namespace

void DuplicateWatch::Heard(const StageStatus& status) {
  const StageStatus own = monitor_.Snapshot();
  if (status.stage != own.stage || status.state == StageStatus::State::kStopped ||
      (status.pid == own.pid && status.host == own.host)) {
    return;
  }
  if (told_.size() == kMaxTwins || !told_.insert({status.host, status.pid}).second) return;
  monitor_.Warn("another sprout-" + status.stage + " works on these channels, process " +
                std::to_string(status.pid) + " on " + status.host +
                ": stop one of the two, or give it another --channel-prefix");
}

}  // namespace sprout
