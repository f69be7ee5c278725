#include "services/tools/log/channel_summary.h"

#include <fmt/core.h>

#include <algorithm>
#include <limits>

#include "common/messages/message_type.h"
#include "common/messages/planar_lidar.h"
#include "common/messages/preview.h"
#include "services/tools/log/channels.h"

namespace sprout::log {
namespace {

std::string TypeText(std::span<const uint8_t> bytes) {
  if (const auto type = TypeOf(bytes)) return NameOf(*type);
  if (IsPreview(bytes)) return kPreviewType;
  if (IsScan(bytes)) return kScanType;
  const auto fingerprint = FingerprintOf(bytes);
  return fingerprint ? fmt::format("0x{:016x}", *fingerprint) : "no type";
}

bool CarriesFrames(MessageType type) {
  return type != MessageType::kRig && type != MessageType::kStatus &&
         type != MessageType::kProcess && type != MessageType::kRigChange;
}

Result<FrameId> Check(const LogEvent& event, const std::optional<MessageType>& type) {
  const auto wanted = TypeOfChannel(event.channel);
  if (wanted && type != wanted) {
    return Fail("fingerprint " + TypeText(event.data) + " is not that of " + NameOf(*wanted));
  }
  if (!type) return FrameId{};
  auto message = DecodeAs(*type, event.data);
  if (!message) return tl::unexpected(message.error());
  return std::move(message->id);
}

}  // namespace

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

}  // namespace sprout::log
