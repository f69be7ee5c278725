#include "common/bus/datagram_joiner.h"

#include <algorithm>
#include <new>
#include <opencv2/core.hpp>

namespace sprout {
namespace {

constexpr uint32_t kShortMagic = 0x4c433032;  // "LC02"
constexpr size_t kMaxChannelBytes = 63;
constexpr size_t kMaxDone = 1024;

uint32_t BigEndian(std::span<const uint8_t> bytes) {
  uint32_t value = 0;
  for (const uint8_t byte : bytes) value = value << 8 | byte;
  return value;
}

// Takes the channel off the front; nothing when there is none that LCM allows.
std::optional<std::string_view> TakeChannel(std::span<const uint8_t>& bytes) {
  const auto end = std::find(bytes.begin(), bytes.end(), uint8_t{0});
  const auto length = static_cast<size_t>(end - bytes.begin());
  if (end == bytes.end() || length > kMaxChannelBytes) return std::nullopt;
  const std::string_view channel(reinterpret_cast<const char*>(bytes.data()), length);
  bytes = bytes.subspan(length + 1);
  return channel;
}

}  // namespace

MessageBytes MessageBytes::OfSize(size_t size) {
  try {
    return {cv::Mat1b(1, static_cast<int>(size))};
  } catch (const cv::Exception&) {  // OpenCV's own name for it
    throw std::bad_alloc();
  }
}

/// One datagram of several.
struct DatagramJoiner::Fragment {
  static constexpr size_t kHeaderBytes = 12;  // behind magic and number

  size_t message_bytes;
  size_t offset;
  size_t index;
  size_t count;

  explicit Fragment(std::span<const uint8_t> header)
      : message_bytes(BigEndian(header.subspan(0, 4))),
        offset(BigEndian(header.subspan(4, 4))),
        index(BigEndian(header.subspan(8, 2))),
        count(BigEndian(header.subspan(10, 2))) {}

  bool IsPossible() const {
    return message_bytes > 0 && message_bytes <= kMaxMessageBytes && index < count;
  }
};

std::optional<DatagramJoiner::Message> DatagramJoiner::Add(const Sender& sender,
                                                           std::span<const uint8_t> datagram,
                                                           Time now) {
  constexpr size_t kStart = 8;  // magic and number
  if (datagram.size() < kStart) return std::nullopt;
  const uint32_t magic = BigEndian(datagram.subspan(0, 4));
  const Name name{sender, BigEndian(datagram.subspan(4, 4))};
  if (magic == kShortMagic) return AddShort(name, datagram.subspan(kStart), now);
  if (magic == kLongMagic) return AddFragment(name, datagram.subspan(kStart), now);
  return std::nullopt;
}

std::optional<DatagramJoiner::Message> DatagramJoiner::AddShort(const Name& name,
                                                                std::span<const uint8_t> rest,
                                                                Time now) {
  const auto channel = TakeChannel(rest);
  if (!channel || IsDone(name, now)) return std::nullopt;
  const size_t wanted = wanted_(*channel);
  if (wanted == 0) return std::nullopt;
  rest = rest.first(std::min(rest.size(), wanted));
  Message message{.channel = std::string(*channel), .bytes = MessageBytes::OfSize(rest.size())};
  std::copy(rest.begin(), rest.end(), message.bytes.memory.data);
  done_.emplace_back(name, now);
  return message;
}

std::optional<DatagramJoiner::Message> DatagramJoiner::AddFragment(const Name& name,
                                                                   std::span<const uint8_t> rest,
                                                                   Time now) {
  if (rest.size() < Fragment::kHeaderBytes) return std::nullopt;
  const Fragment fragment(rest);
  rest = rest.subspan(Fragment::kHeaderBytes);
  std::optional<std::string_view> channel;
  if (fragment.index == 0 && !(channel = TakeChannel(rest))) return std::nullopt;
  if (!fragment.IsPossible() || fragment.offset > fragment.message_bytes ||
      rest.size() > fragment.message_bytes - fragment.offset || IsDone(name, now)) {
    return std::nullopt;
  }
  Pending* pending = FindOrStart(name, fragment);
  if (pending == nullptr || pending->has[fragment.index]) return std::nullopt;
  if (channel) {
    pending->message.channel = *channel;
    pending->wanted = wanted_(*channel);
  }
  pending->has[fragment.index] = true;
  if (fragment.offset < pending->wanted) {
    std::copy(rest.begin(), rest.end(), pending->message.bytes.memory.data + fragment.offset);
  }
  // Bytes and datagrams of a message end together; otherwise some overlap, and leave holes
  // elsewhere.
  const bool possible = rest.size() <= pending->missing_bytes;
  pending->missing_bytes -= possible ? rest.size() : pending->missing_bytes;
  if (pending->missing_bytes > 0) return std::nullopt;
  const bool all = std::find(pending->has.begin(), pending->has.end(), false) == pending->has.end();
  std::optional<Message> whole;
  if (possible && all && pending->wanted > 0) {
    whole = std::move(pending->message);
    const size_t wanted = std::min(whole->bytes.size(), pending->wanted);
    whole->bytes.memory = whole->bytes.memory.colRange(0, static_cast<int>(wanted));
  }
  DropPending(*pending);
  done_.emplace_back(name, now);
  return whole;
}

// Nothing when it contradicts what came before.
DatagramJoiner::Pending* DatagramJoiner::FindOrStart(const Name& name, const Fragment& fragment) {
  const auto found = std::find_if(pending_.begin(), pending_.end(),
                                  [&](const Pending& pending) { return pending.name == name; });
  if (found != pending_.end()) {
    const bool agrees =
        found->has.size() == fragment.count && found->message_bytes == fragment.message_bytes;
    return agrees ? &*found : nullptr;
  }
  while (pending_.size() >= kMaxPending ||
         (!pending_.empty() && pending_bytes_ + fragment.message_bytes > kMaxPendingBytes)) {
    DropPending(pending_.front());
  }
  Pending& started = pending_.emplace_back(
      Pending{.name = name,
              .message = {.channel = {}, .bytes = MessageBytes::OfSize(fragment.message_bytes)},
              .message_bytes = fragment.message_bytes,
              .has = std::vector<bool>(fragment.count),
              .missing_bytes = fragment.message_bytes});
  pending_bytes_ += fragment.message_bytes;  // behind what may throw
  return &started;
}

void DatagramJoiner::DropPending(const Pending& pending) {
  const Name name = pending.name;
  const auto found = std::find_if(pending_.begin(), pending_.end(),
                                  [&](const Pending& other) { return other.name == name; });
  pending_bytes_ -= found->message_bytes;
  pending_.erase(found);
}

bool DatagramJoiner::IsDone(const Name& name, Time now) {
  while (!done_.empty() && (done_.size() > kMaxDone || done_.front().second < now - kRemembered)) {
    done_.pop_front();
  }
  return std::any_of(done_.rbegin(), done_.rend(),
                     [&](const auto& done) { return done.first == name; });
}

}  // namespace sprout
