#include "common/app/frames_under_way.h"

#include <algorithm>

namespace sprout {
namespace {

// Frames that are kept where no stage answers; older ones are forgotten.
constexpr size_t kMaxUnanswered = 64;

}  // namespace

void FramesUnderWay::Sent(const FrameId& id, Clock::duration time) {
  const std::lock_guard lock(mutex_);
  under_way_.push_back({.id = id, .sent = now_(), .reached_last = now_(), .first = time});
  if (under_way_.size() > kMaxUnanswered) under_way_.pop_front();
}

// A stage works on a frame from when it came or the one before was answered, whatever is later.
void FramesUnderWay::Passed(const FrameId& id) {
  const std::lock_guard lock(mutex_);
  const auto it = std::ranges::find(under_way_, id, &UnderWay::id);
  if (it == under_way_.end()) return;
  it->reached_last = now_();
  it->second = it->reached_last - std::max(it->sent, newest_passed_);
  newest_passed_ = it->reached_last;
}

void FramesUnderWay::Answered(const FrameId& id) {
  {
    const std::lock_guard lock(mutex_);
    const auto it = std::ranges::find(under_way_, id, &UnderWay::id);
    if (it == under_way_.end()) return;
    const auto now = now_();
    times_.push_back({.first = it->first,
                      .second = it->second,
                      .last = now - std::max(it->reached_last, newest_answered_),
                      .behind_first = now - it->sent});
    if (times_.size() > kRemembered) times_.pop_front();
    newest_answered_ = now;
    under_way_.erase(under_way_.begin(), it + 1);
  }
  changed_.notify_all();
}

std::optional<size_t> FramesUnderWay::Most() const {
  const std::lock_guard lock(mutex_);
  return MostLocked();
}

std::optional<size_t> FramesUnderWay::MostLocked() const {
  if (times_.empty()) return std::nullopt;
  Times sum{};
  for (const Times& times : times_) {
    sum.first += times.first;
    sum.second += times.second;
    sum.last += times.last;
  }
  const auto all = sum.first + sum.second + sum.last;
  const auto slowest = std::max({sum.first, sum.second, sum.last, Clock::duration(1)});
  return static_cast<size_t>((all + slowest - Clock::duration(1)) / slowest);
}

bool FramesUnderWay::WaitForRoom(std::chrono::milliseconds time, const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  auto deadline = Clock::now() + time;
  if (!under_way_.empty() && !times_.empty()) {
    deadline = std::min(deadline, under_way_.front().sent + Patience());
  }
  changed_.wait_until(lock, stop, deadline, [this] { return HasRoomLocked(); });
  return !stop.stop_requested() && HasRoomLocked();
}

bool FramesUnderWay::HasRoomLocked() {
  if (times_.empty()) return true;
  if (!under_way_.empty() && now_() - under_way_.front().sent > Patience()) {
    times_.clear();
    under_way_.clear();
    return true;
  }
  return under_way_.size() < *MostLocked();
}

FramesUnderWay::Clock::duration FramesUnderWay::Patience() const {
  return kPatience * std::ranges::max_element(times_, {}, &Times::behind_first)->behind_first;
}

}  // namespace sprout
