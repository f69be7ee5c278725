#include "services/tools/log/channel_summary.h"

#include <fmt/core.h>

#include <algorithm>
#include <limits>

#include "common/config/config_difference.h"
#include "common/core/printable.h"
#include "common/messages/codec.h"
#include "common/messages/preview.h"

namespace sprout::log {
namespace {

constexpr size_t kRecentFrames = 64;  // a frame is known to be repeated among so many
constexpr size_t kShownGaps = 10;
// A frame whose time is before the newest one's by more comes from a capture that was started again
// with its clock set back, µs.
constexpr int64_t kMaxLateUs = 10'000'000;

std::string TypeText(std::span<const uint8_t> bytes) {
  if (const auto type = TypeOf(bytes)) return NameOf(*type);
  if (IsPreview(bytes)) return kPreviewType;
  if (IsScan(bytes)) return kScanType;
  const auto fingerprint = FingerprintOf(bytes);
  return fingerprint ? fmt::format("0x{:016x}", *fingerprint) : "no type";
}

Result<FrameId> Check(const LogEvent& event, const std::optional<MessageType>& type) {
  const auto wanted = TypeOfChannel(event.channel);
  if (wanted && !FingerprintOf(event.data)) {
    return Fail(fmt::format("{} bytes, too few for a {}", event.data.size(), NameOf(*wanted)));
  }
  if (wanted && type != wanted) {
    return Fail("fingerprint " + TypeText(event.data) + " is not that of " + NameOf(*wanted));
  }
  if (!type) return FrameId{};
  auto message = DecodeAs(*type, event.data);
  if (!message) return tl::unexpected(message.error());
  return std::move(message->id);
}

}  // namespace

bool CarriesFrames(MessageType type) {
  return type != MessageType::kRig && type != MessageType::kStatus &&
         type != MessageType::kProcess && type != MessageType::kRigChange;
}

void Sequence::Add(const FrameId& id) {
  if (std::find(recent_.begin(), recent_.end(), id) != recent_.end()) {
    ++repeated_;
    return;
  }
  if (rigs_.size() < kMaxRigs) rigs_.insert(id.rig_id);
  recent_.push_back(id);
  if (recent_.size() > kRecentFrames) recent_.pop_front();
  first_ = std::min(first_.value_or(id.seq), id.seq);
  last_ = std::max(last_.value_or(id.seq), id.seq);
  steps_ += newest_ && id.seq > newest_->seq;
  times_back_ += newest_ && id.seq > newest_->seq && id.utime <= newest_->utime;
  if (newest_ && id.seq - 1 > newest_->seq) {
    const Gap gap{newest_->seq + 1, id.seq - 1};
    // A damaged number can be anything; the sum must not overflow.
    if (__builtin_add_overflow(missing_, gap.last - gap.first + 1, &missing_)) {
      missing_ = std::numeric_limits<int64_t>::max();
    }
    ++gap_count_;
    if (gaps_.size() < kShownGaps) gaps_.push_back(gap);
  } else if (newest_ && id.seq <= newest_->seq) {
    if (id.utime <= newest_->utime && id.utime > newest_->utime - kMaxLateUs) {
      ++late_;
      return;
    }
    ++restarts_;
  }
  newest_ = id;
}

void Sequence::ExpectEvery(int64_t every) {
  if (every == 1) return;
  constexpr int64_t kMax = std::numeric_limits<int64_t>::max();
  const int64_t numbers = missing_ < kMax - steps_ ? missing_ + steps_ : kMax;
  missing_ = std::max<int64_t>(0, numbers / every - steps_);
  gaps_.clear();
  gap_count_ = missing_;
}

std::string Sequence::GapText() const {
  std::string text;
  for (const Gap& gap : gaps_) {
    if (!text.empty()) text += ", ";
    text += std::to_string(gap.first);
    if (gap.last > gap.first) text += "-" + std::to_string(gap.last);
  }
  if (text.empty()) return std::to_string(gap_count_) + " in all";
  return gap_count_ > static_cast<int64_t>(gaps_.size()) ? text + ", ..." : text;
}

std::string WhyUndecodable(const LogEvent& event) {
  const auto checked = Check(event, TypeOf(event.data));
  return checked ? "" : checked.error().text;
}

void ChannelSummary::Add(const LogEvent& event) {
  if (events_ == 0) {
    type_ = TypeText(event.data);
    first_utime_ = last_utime_ = event.utime;
  }
  ++events_;
  bytes_ += static_cast<int64_t>(event.data.size());
  first_utime_ = std::min(first_utime_, event.utime);
  last_utime_ = std::max(last_utime_, event.utime);

  const auto type = TypeOf(event.data);
  const auto id = Check(event, type);
  if (!id) {
    if (undecodable_++ == 0) {
      first_error_ =
          fmt::format("event {} at byte {}: {}", event.number, event.offset, id.error().text);
    }
  } else if (type && CarriesFrames(*type)) {
    has_frames_ = true;
    sequence_.Add(*id);
  }
}

double ChannelSummary::rate_hz() const {
  // Computed as double: damaged times may be further apart than an integer holds.
  const double seconds =
      (static_cast<double>(last_utime_) - static_cast<double>(first_utime_)) / 1e6;
  return seconds > 0 ? static_cast<double>(events_ - 1) / seconds
                     : std::numeric_limits<double>::quiet_NaN();
}

void ProcessSummary::Add(std::span<const uint8_t> bytes) {
  Result<ProcessInfo> info = DecodeProcessInfo(bytes);
  if (!info || processes_.size() == kMaxProcesses) return;
  if (std::ranges::find(processes_, *info) != processes_.end()) return;
  processes_.push_back(*std::move(info));
}

const ProcessInfo* ProcessSummary::NewestOf(const std::string& stage) const {
  const auto found = std::find_if(processes_.rbegin(), processes_.rend(),
                                  [&](const ProcessInfo& info) { return info.stage == stage; });
  return found == processes_.rend() ? nullptr : &*found;
}

std::string ConfigDiffText(const ProcessSummary& a, const ProcessSummary& b) {
  std::set<std::string> stages;
  for (const ProcessInfo& info : a.processes()) stages.insert(info.stage);
  std::string text;
  for (const std::string& stage : stages) {
    const ProcessInfo& in_a = *a.NewestOf(stage);
    const ProcessInfo* const in_b = b.NewestOf(stage);
    if (in_b == nullptr) continue;
    if (in_a.version != in_b->version) {
      text += Printable(
                  fmt::format("{}: version {} in A, {} in B", stage, in_a.version, in_b->version)) +
              "\n";
    }
    for (const auto& [key, value_a, value_b] :
         ConfigDifferences(in_a.config_text, in_b->config_text)) {
      text +=
          Printable(fmt::format("{}: {} = {} in A, {} in B", stage, key, value_a, value_b)) + "\n";
    }
  }
  return text;
}

}  // namespace sprout::log
