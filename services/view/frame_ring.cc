#include "services/view/frame_ring.h"

#include <algorithm>
#include <utility>

#include "common/bus/channels.h"
#include "common/logfile/log_writer.h"
#include "common/messages/codec.h"
#include "common/messages/message_type.h"

namespace sprout::view {
namespace {

using std::chrono::seconds;

// Parts that are shown and waited for. Those that only the left camera sees come before the prior.
// Depth and cloud, which may come for every tenth frame only, the page makes of the disparities.
constexpr std::array kShownParts = {Part::kLeft,  Part::kTof,       Part::kSeeds,
                                    Part::kPrior, Part::kDisparity, Part::kConfidence,
                                    Part::kSigma, Part::kFused};

// A part is expected as long as it comes at its pace, at least for the first, at most for the
// second of these times.
constexpr seconds kMinPatience{3};
constexpr seconds kMaxPatience{30};

// Memory of a message besides its bytes.
constexpr size_t kOverheadBytes = 256;

// How long messages that belong to no frame are kept while no frame comes, µs.
constexpr int64_t kIdleUtime = 300'000'000;

constexpr size_t kMaxRigs = 16;

bool IsShown(Part part) {
  return part == Part::kLeftSeeds ||
         std::find(kShownParts.begin(), kShownParts.end(), part) != kShownParts.end();
}

bool SameBytes(const StoredBytes& old, std::span<const uint8_t> bytes) {
  return old && std::equal(old->begin(), old->end(), bytes.begin(), bytes.end());
}

}  // namespace

Result<bool> FrameRing::Add(std::string_view channel, std::span<const uint8_t> bytes, int64_t utime,
                            Clock::time_point now) {
  const auto message = std::make_shared<const std::vector<uint8_t>>(bytes.begin(), bytes.end());
  const std::optional<Part> part = PartOf(channel);
  Result<FrameId> id = FrameId{};
  if (part) {
    if (TypeOf(bytes) != TypeOf(*part)) return Fail("not of type " + NameOf(TypeOf(*part)));
    id = DecodeFrameId(bytes);
    if (!id) return tl::unexpected(id.error());
    // A calibration is kept beyond its event, and not counted: a whole one is small.
    if (part == Part::kRig) {
      if (const auto rig = DecodePart(*part, bytes); !rig) return tl::unexpected(rig.error());
    }
  }
  const std::lock_guard lock(mutex_);
  events_.push_back({utime, std::string(channel), message});
  event_bytes_ += bytes.size() + kOverheadBytes;
  bool announced = false;
  if (part == Part::kRig) {
    AddRig(*id, message);
  } else if (part) {
    Pace& pace = paces_[static_cast<size_t>(*part)];
    if (pace.last) pace.interval = now - *pace.last;
    pace.last = now;
    StoredFramePtr& frame = FindOrStart(*id);
    if (started_.size() < frames_.size())
      started_.push_back(dropped_events_ + std::ssize(events_) - 1);
    if (!SameBytes(frame->part(*part), bytes)) {
      auto changed = std::make_shared<StoredFrame>(*frame);
      changed->parts[static_cast<size_t>(*part)] = message;
      if (IsShown(*part)) ++changed->version;
      if (newest_ == frame) newest_ = changed;
      frame = std::move(changed);
      announced = IsShown(*part) && Announce(frame, now);
    }
  }
  Forget();
  return announced;
}

// Adds the calibration also to earlier frames: it may come after the first that it belongs to.
void FrameRing::AddRig(const FrameId& id, const StoredBytes& bytes) {
  std::erase_if(rigs_, [&](const auto& rig) { return rig.first == id.rig_id; });
  rigs_.emplace_back(id.rig_id, bytes);
  if (rigs_.size() > kMaxRigs) rigs_.pop_front();
  for (StoredFramePtr& frame : frames_) {
    if (frame->id.rig_id != id.rig_id || frame->Has(Part::kRig)) continue;
    auto changed = std::make_shared<StoredFrame>(*frame);
    changed->parts[static_cast<size_t>(Part::kRig)] = bytes;
    ++changed->version;
    if (newest_ == frame) newest_ = changed;
    frame = std::move(changed);
  }
}

StoredFramePtr& FrameRing::FindOrStart(const FrameId& id) {
  const auto found = std::find_if(frames_.rbegin(), frames_.rend(),
                                  [&](const StoredFramePtr& frame) { return frame->id == id; });
  if (found != frames_.rend()) return *found;
  auto frame = std::make_shared<StoredFrame>();
  frame->key = next_key_++;
  frame->id = id;
  for (const auto& [rig_id, bytes] : rigs_) {
    if (rig_id == id.rig_id) frame->parts[static_cast<size_t>(Part::kRig)] = bytes;
  }
  return frames_.emplace_back(std::move(frame));
}

bool FrameRing::IsExpected(Part part, Clock::time_point now) const {
  const Pace& pace = paces_[static_cast<size_t>(part)];
  const Clock::duration patience =
      std::clamp<Clock::duration>(3 * pace.interval, kMinPatience, kMaxPatience);
  return pace.last && now - *pace.last < patience;
}

bool FrameRing::IsComplete(const StoredFrame& frame, Clock::time_point now) const {
  return std::all_of(kShownParts.begin(), kShownParts.end(),
                     [&](Part part) { return frame.Has(part) || !IsExpected(part, now); });
}

bool FrameRing::Announce(const StoredFramePtr& frame, Clock::time_point now) {
  if (newest_ && frame->key < newest_->key) return false;
  // Better an incomplete frame than none: parts of different frames may never meet.
  const bool starved = !newest_ || now - newest_since_ > kMaxPatience;
  const bool grew = newest_ && frame->key == newest_->key;
  if (!starved && !grew && !IsComplete(*frame, now)) return false;
  newest_ = frame;
  newest_since_ = now;
  return true;
}

void FrameRing::DropFrontEvent() {
  event_bytes_ -= events_.front().bytes->size() + kOverheadBytes;
  events_.pop_front();
  ++dropped_events_;
}

void FrameRing::Forget() {
  const auto drop_frame = [this] {
    frames_.pop_front();
    started_.pop_front();
  };
  while (frames_.size() > kMaxFrames) drop_frame();
  const int64_t idle_since = events_.back().utime - kIdleUtime;
  const auto is_old = [&] {
    return started_.empty() ? events_.front().utime < idle_since
                            : dropped_events_ < started_.front();
  };
  const auto drop_old_events = [&] {
    while (events_.size() > 1 && is_old()) DropFrontEvent();
  };
  drop_old_events();
  while (event_bytes_ > max_bytes_ && frames_.size() > 1) {
    short_ = true;
    drop_frame();
    drop_old_events();
  }
  // Events are also bounded by their bytes: there may be no frames to go by, or the clock was set
  // back.
  while (event_bytes_ > max_bytes_ && events_.size() > 1) DropFrontEvent();
}

StoredFramePtr FrameRing::Newest() const {
  const std::lock_guard lock(mutex_);
  return newest_;
}

StoredFramePtr FrameRing::Get(int64_t key) const {
  const std::lock_guard lock(mutex_);
  if (frames_.empty() || key < frames_.front()->key || key > frames_.back()->key) return nullptr;
  return frames_[static_cast<size_t>(key - frames_.front()->key)];
}

KeyRange FrameRing::keys() const {
  const std::lock_guard lock(mutex_);
  if (frames_.empty() || !newest_) return {};
  // Frames behind the newest are still on their way through the graph.
  return {std::min(frames_.front()->key, newest_->key), newest_->key};
}

std::vector<StoredFramePtr> FrameRing::Snapshot() const {
  const std::lock_guard lock(mutex_);
  std::vector<StoredFramePtr> frames;
  for (const StoredFramePtr& frame : frames_) {
    if (newest_ && frame->key <= newest_->key) frames.push_back(frame);
  }
  return frames;
}

size_t FrameRing::bytes() const {
  const std::lock_guard lock(mutex_);
  return event_bytes_;
}

bool FrameRing::is_short() const {
  const std::lock_guard lock(mutex_);
  return short_;
}

int64_t FrameRing::WriteLog(const std::filesystem::path& path, const std::string& prefix,
                            double seconds) const {
  std::vector<Event> wanted;
  std::vector<StoredBytes> rigs;
  {
    const std::lock_guard lock(mutex_);
    const int64_t newest = events_.empty() ? 0 : events_.back().utime;
    const int64_t since = newest - static_cast<int64_t>(seconds * 1e6);
    std::copy_if(events_.begin(), events_.end(), std::back_inserter(wanted),
                 [&](const Event& event) { return event.utime >= since; });
    for (const auto& [rig_id, bytes] : rigs_) rigs.push_back(bytes);
  }
  LogWriter writer(path);
  // A log that begins between two calibrations could not be replayed.
  const int64_t start = wanted.empty() ? 0 : wanted.front().utime;
  for (const StoredBytes& rig : rigs) {
    writer.Write(start, prefix + std::string(ChannelOf(Part::kRig)), *rig);
  }
  for (const Event& event : wanted) writer.Write(event.utime, prefix + event.channel, *event.bytes);
  writer.Close();
  return writer.events();
}

}  // namespace sprout::view
