#include "services/tools/log/event_stream.h"

#include <utility>

#include "common/core/digest.h"
#include "common/messages/codec.h"
#include "common/messages/message_type.h"

namespace sprout::log {
namespace {

constexpr size_t kRecentMessages = 64;  // a message is known to be repeated among so many

uint64_t HashOf(std::span<const uint8_t> bytes) {
  return Hash({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

bool IsProcess(const LogEvent& event) { return TypeOf(event.data) == MessageType::kProcess; }

bool IsLeftOutByDefault(const LogEvent& event) {
  const auto type = TypeOf(event.data);
  return event.channel == "LCM_SELF_TEST" || type == MessageType::kStatus ||
         type == MessageType::kRigChange || IsProcess(event);
}

}  // namespace

ChannelFilter::ChannelFilter(const std::vector<std::string>& names, std::string prefix)
    : prefix_(std::move(prefix)) {
  for (const std::string& name : names) names_.insert(prefix_ + name);
}

bool ChannelFilter::Has(std::string_view channel) const {
  return names_.empty() ? channel.starts_with(prefix_) : names_.contains(channel);
}

EventStream::EventStream(const std::filesystem::path& path, const ChannelFilter& filter)
    : reader_(path), filter_(filter) {}

bool EventStream::Next() {
  for (LogEvent event; reader_.Next(event);) {
    if (event.channel.starts_with(filter_.prefix()) && IsProcess(event)) processes_.Add(event.data);
    if (!filter_.Has(event.channel)) continue;
    if (filter_.names().empty() && IsLeftOutByDefault(event)) continue;
    SetKey(event);
    if (IsRepeated()) {
      if (key_.rig_id.empty()) ++repeated_;
      continue;
    }
    ++events_;
    return true;
  }
  return false;
}

void EventStream::SetKey(const LogEvent& event) {
  key_ = EventKey();
  key_.channel = event.channel;
  digest_ = {.offset = event.offset,
             .bytes = static_cast<int64_t>(event.data.size()),
             .hash = HashOf(event.data)};
  utime_ = event.utime;
  const auto type = TypeOf(event.data);
  const auto id = type ? DecodeFrameId(event.data) : Fail("");
  if (!id) {
    key_.seq = headerless_[key_.channel]++;
    return;
  }
  if (type != MessageType::kRig) {
    key_.utime = utime_ = id->utime;
    key_.seq = id->seq;
    return;
  }
  // A calibration is sent once a second with the header of the frame that is then the newest, so
  // only its content is compared.
  key_.rig_id = id->rig_id;
  if (const auto rig = DecodePart(Part::kRig, event.data)) {
    digest_.bytes = 0;
    digest_.hash = Hash(RigId(std::get<Rig>(rig->value)));
  }
}

bool EventStream::IsRepeated() {
  std::deque<Recent>& recent = recent_[key_.channel];
  const EventKey unversioned = key_;
  for (const Recent& other : recent) {
    if (other.key != unversioned) continue;
    if (other.digest.SameBytes(digest_)) return true;
    ++key_.version;
  }
  recent.push_back({unversioned, digest_});
  if (recent.size() > kRecentMessages) recent.pop_front();
  return false;
}

}  // namespace sprout::log
