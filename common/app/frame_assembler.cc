#include "common/app/frame_assembler.h"

#include <algorithm>
#include <exception>
#include <utility>

#include "common/core/digest.h"
#include "common/core/printable.h"
#include "common/messages/codec.h"

namespace sprout {
namespace {

// Messages among which a second answer for a frame is looked for: those of some ten frames. Farther
// back, frames of a log that plays in a loop may have had another answer by right.
constexpr size_t kMaxTaken = 48;

// Takes the first KB of every 16 KB of a message: different answers for a frame differ there, too,
// and all bytes would take 1 to 2 ms for a frame of 2 MP.
uint64_t HashOf(std::span<const uint8_t> bytes) {
  constexpr size_t kPart = 1024, kStep = 16 * kPart;
  uint64_t hash = bytes.size();
  for (size_t at = 0; at < bytes.size(); at += kStep) {
    const auto part = bytes.subspan(at, std::min(kPart, bytes.size() - at));
    hash = 31 * hash + Hash({reinterpret_cast<const char*>(part.data()), part.size()});
  }
  return hash;
}

}  // namespace

FrameAssembler::FrameAssembler(PartSet needed, StageMonitor& monitor, size_t max_pending,
                               PartSet optional)
    : monitor_(monitor),
      needed_(needed),
      joiner_(needed, max_pending, FrameJoiner::kDefaultMaxBytes, optional) {
  for (const Part part : kAllParts) {
    if (needed_.Has(part)) channels_.push_back(ChannelOf(part));
  }
}

std::vector<Frame> FrameAssembler::Add(std::string_view channel, std::span<const uint8_t> bytes,
                                       const cv::Mat1b& memory) {
  const std::optional<Part> part = PartOf(channel);
  if (!part || !needed_.Has(*part)) return {};
  try {
    const Taken message{
        .id = DecodeFrameId(bytes).value_or(FrameId{}), .part = *part, .hash = HashOf(bytes)};
    if (IsSecondAnswer(message)) {
      monitor_.BadMessage(channel, "frame " + std::to_string(message.id.seq) +
                                       " has two that differ, the first counts: two programs send "
                                       "them, or utime and seq are those of an earlier frame");
      return {};
    }
    Result<std::vector<Frame>> frames = joiner_.AddMessage(*part, bytes, memory);
    if (frames) {
      taken_.push_back(message);
      if (taken_.size() > kMaxTaken) taken_.pop_front();
      monitor_.SetJoinerCounts(joiner_.incomplete(), joiner_.sequence_gaps());
      TellOtherRig(message.id);
      if (needed_.Has(Part::kTof) && part != Part::kRig) TellTimesBack(message.id, frames->size());
      return std::move(*frames);
    }
    monitor_.BadMessage(channel, frames.error().text);
  } catch (const std::exception& e) {  // out of memory
    monitor_.BadMessage(channel, e.what());
  }
  return {};
}

// Whether the frame has had this part before, with other bytes. Calibrations come every second,
// each with its own time, and do not count.
bool FrameAssembler::IsSecondAnswer(const Taken& message) const {
  return message.part != Part::kRig && std::ranges::any_of(taken_, [&](const Taken& other) {
           return other.part == message.part && other.id == message.id &&
                  other.hash != message.hash;
         });
}

void FrameAssembler::TellOtherRig(const FrameId& id) {
  if (joiner_.rigs_replaced() == std::exchange(rigs_replaced_, joiner_.rigs_replaced())) return;
  monitor_.Warn("SPROUT_RIG: rig_id '" + Printable(id.rig_id) +
                "' again, with other numbers, which are used now: a changed calibration needs "
                "another rig_id");
}

// Whether an earlier frame, but not the one before, had this time. A clock does not come to the
// same µs again, a short recording that plays in a loop (mcap:) does.
bool FrameAssembler::IsKnownTime(int64_t utime) {
  if (!utimes_.empty() && utimes_.back() == utime) return false;
  const bool is_known = std::ranges::find(utimes_, utime) != utimes_.end();
  utimes_.push_back(utime);
  if (utimes_.size() > kFramesTold) utimes_.pop_front();
  return is_known;
}

// Warns of times that do not rise from the second step back on: a single one is that of a clock,
// and capture and stages with memory report it.
void FrameAssembler::TellTimesBack(const FrameId& id, size_t whole_frames) {
  const bool is_known = IsKnownTime(id.utime);
  if (joiner_.times_back() != std::exchange(times_back_, joiner_.times_back()) && !is_known) {
    const bool again = std::exchange(frames_since_back_, 0) < kFramesTold;
    if (!again || !time_warning_.empty()) return;
    time_warning_ = "frame " + std::to_string(id.seq) +
                    ": utime does not rise from the frame before, again: it must be the time of "
                    "exposure, which rises with seq";
    monitor_.Warn(time_warning_);
    monitor_.HoldWarning(time_warning_);
  } else if ((frames_since_back_ += whole_frames) >= kFramesTold && !time_warning_.empty()) {
    monitor_.Resolve(std::exchange(time_warning_, ""));
  }
}

std::vector<Frame> FrameAssembler::Finish() {
  std::vector<Frame> last = joiner_.DropPending();
  monitor_.SetJoinerCounts(joiner_.incomplete(), joiner_.sequence_gaps());
  return last;
}

}  // namespace sprout
