#include "services/capture/answer_tracker.h"

#include <algorithm>

#include "common/bus/channels.h"
#include "common/messages/codec.h"

namespace sprout::capture {
namespace {

std::vector<std::string_view> Channels(bool disparities) {
  if (disparities) return {kStatusChannel, ChannelOf(Part::kDisparity)};
  return {kStatusChannel};
}

// Longest period between frames, s: 30 years, which a clock can still count.
constexpr double kLongestPeriodS = 1e9;

// The time from which the next period counts, for a frame that was due at `due` and comes `now`:
// after a stall it is `now`, so that no backlog is sent in a burst.
Pace::Clock::time_point WithoutBacklog(Pace::Clock::time_point due, Pace::Clock::time_point now,
                                       Pace::Clock::duration interval) {
  return now - due > interval ? now : due;
}

}  // namespace

AnswerTracker::AnswerTracker(const ServiceContext& context, StageMonitor& monitor,
                             const std::vector<std::string>& stages, bool disparities)
    : monitor_(monitor),
      duplicates_(monitor),
      silent_(stages.begin(), stages.end()),
      receiver_(
          context.lcm_url, context.prefix, Channels(disparities),
          [this](std::string_view channel, std::span<const uint8_t> bytes) {
            OnMessage(channel, bytes);
          },
          [this](std::string_view channel) { monitor_.MessageDropped(channel); }) {}

void AnswerTracker::OnMessage(std::string_view channel, std::span<const uint8_t> bytes) {
  try {
    channel == kStatusChannel ? OnStatus(bytes) : OnDisparity(bytes);
  } catch (const std::exception& e) {  // out of memory
    monitor_.BadMessage(channel, e.what());
  }
  changed_.notify_all();
}

void AnswerTracker::OnStatus(std::span<const uint8_t> bytes) {
  const Result<StageStatus> status = DecodeStatus(bytes);
  if (!status) return monitor_.BadMessage(kStatusChannel, status.error().text);
  duplicates_.Heard(*status);
  const std::lock_guard lock(mutex_);
  // The last status of a process that ends does not mean that the stage is there.
  if (status->state == StageStatus::State::kStopped) return;
  silent_.erase(status->stage);
  if (status->stage != "capture" && reported_.size() < kMaxReported)
    reported_.insert(status->stage);
}

std::set<std::string> AnswerTracker::reported() {
  const std::lock_guard lock(mutex_);
  return reported_;
}

void AnswerTracker::OnDisparity(std::span<const uint8_t> bytes) {
  const Result<DecodedPart> part = DecodePart(Part::kDisparity, bytes);
  if (!part) return monitor_.BadMessage(ChannelOf(Part::kDisparity), part.error().text);
  const std::lock_guard lock(mutex_);
  std::erase(missing_, part->id);
}

std::set<std::string> AnswerTracker::WaitForStages(Deadline deadline, const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  changed_.wait_until(lock, stop, deadline, [&] { return silent_.empty(); });
  return silent_;
}

void AnswerTracker::Expect(const FrameId& id) {
  const std::lock_guard lock(mutex_);
  missing_.push_back(id);
}

bool AnswerTracker::IsAnswered(const FrameId& id) {
  const std::lock_guard lock(mutex_);
  return std::find(missing_.begin(), missing_.end(), id) == missing_.end();
}

void AnswerTracker::WaitForRoom(size_t count, Deadline deadline, const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  changed_.wait_until(lock, stop, deadline, [&] { return missing_.size() <= count; });
}

void Pace::Start(Clock::time_point now) { due_ = now; }

Pace::Clock::time_point Pace::DueBeforeTaking() const { return due_; }

std::optional<Pace::Clock::duration> Pace::Period() const {
  if (!rate_hz_ || *rate_hz_ <= 0) return std::nullopt;
  const std::chrono::duration<double> exact(std::min(1 / *rate_hz_, kLongestPeriodS));
  return std::chrono::duration_cast<Clock::duration>(exact);
}

bool Pace::IsLate(Clock::time_point now) const {
  const std::optional<Clock::duration> period = Period();
  return period && now - due_ > *period;
}

void Pace::Take(Clock::time_point now) {
  const std::optional<Clock::duration> period = Period();
  if (period) due_ = WithoutBacklog(due_, now, *period) + *period;
}

Pace::Clock::time_point Pace::DueBeforeSending(const FrameId& id, Clock::time_point now) {
  if (rate_hz_) return now;
  // Neither utime is negative, so no difference overflows.
  const std::chrono::microseconds interval(id.utime - utime_.value_or(id.utime));
  const auto waited = std::clamp<std::chrono::microseconds>(
      interval, std::chrono::microseconds::zero(), kLongestInterval);
  utime_ = id.utime;
  due_ = WithoutBacklog(due_ + waited, now, waited);
  return due_;
}

}  // namespace sprout::capture
